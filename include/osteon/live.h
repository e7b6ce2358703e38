/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The live state of a running operation, passed from the servo thread to one
 * viewer thread, for instance a renderer.
 *
 *   servo thread  --ost_live_changed--> queue of chunks --ost_live_publish, a few a tick--> words, a dirty bit a chunk
 *                 --ost_live_publish--> the state: poses, force, counts
 *   viewer        <--ost_live_state_get-- the newest state
 *                 <--ost_live_take-- every chunk that changed since the last take
 *
 * Both sides are wait-free: they take no lock, allocate no memory, make no
 * system call, and no loop depends on the other thread.  A slow or absent viewer
 * costs the tick nothing: a chunk that changes twice before it is taken is taken
 * once.  No change is lost: after the last tick and ost_live_flush, the chunks
 * taken are bit-identical to the bone.  Before that, a chunk may be seen between
 * two of its states.  Bone is only ever removed, so such a chunk shows bone that
 * existed a moment ago, and the next take corrects it.
 *
 * ost_bone_occupancy copies the words from the backend.  `cpu` and `ref` copy
 * them within a tick's time; `cl` reads them from the device and waits for it, as
 * it does for the report of a removal; `plugin` has none, and ost_live_create
 * fails with OST_ERR_UNAVAILABLE.
 *
 * Threads: changed, publish and flush are called on the servo thread; state_get
 * and take on one viewer thread; create and free while neither uses the object.
 */
#ifndef OSTEON_LIVE_H
#define OSTEON_LIVE_H

#include <osteon/backend.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_live_channel ost_live_channel;

enum { OST_LIVE_TOOLS = 16 };

typedef struct ost_live_state {
    uint64_t ticks;         /* number of ticks so far; 0: none yet */
    int64_t t_ns;           /* time of the last tick */
    int32_t tool;           /* index of the current tool */
    int32_t rpm;            /* speed of its motor (path.h) */
    ost_pose device, pose;  /* poses of the device and of the tool; a contact force separates them */
    double force_n[3], torque_nm[3]; /* hand force and torque, exerted by the device */
    double contact_n;       /* contact force of the tool on the bone */
    double reached_mm[OST_LIVE_TOOLS]; /* by tool: greatest depth of removed bone (depth_of in operation.h) */
    uint64_t removals, removed_voxels;
    uint64_t missed;        /* skipped ticks */
    uint32_t wake_ns, exec_ns; /* delay and duration of the last tick */
    uint32_t touching;      /* bone voxels that the tool touched or removed in the last tick */
    int32_t fault;          /* an ost_fault (operation.h); 0: none */
    bool declared;          /* the device returned no new pose */
} ost_live_state;

/*
 * Creates the live state of a bone, with one bit for every voxel of its active chunks.  The bone must outlive it and
 * must not gain chunks.
 */
OST_API ost_status ost_live_create(const ost_bone *bone, ost_live_channel **out, ost_error *err);
/* Frees a live state. NULL is allowed. */
OST_API void ost_live_free(ost_live_channel *live);

/* ----------------------------------------------------------- servo thread */

/* Queues the chunks of an event's report. NULL is allowed, for a tick without an event. */
OST_API void ost_live_changed(ost_live_channel *live, const ost_removal_report *report);
/* Publishes the state and about 8 kB of queued chunks, two of 32^3. On an error of the backend they stay queued. */
OST_API ost_status ost_live_publish(ost_live_channel *live, const ost_live_state *state, ost_error *err);
/* Publishes all queued chunks, for the end of an operation or a pause. */
OST_API ost_status ost_live_flush(ost_live_channel *live, ost_error *err);

/* ---------------------------------------------------------- viewer thread */

/* Copies the newest state, which may be the one copied before. Returns false if there is none yet. */
OST_API bool ost_live_state_get(ost_live_channel *live, ost_live_state *out);

/*
 * Receives the occupancy of one chunk: its index along x, y and z, and its words in the form of ost_bone_occupancy,
 * valid until it returns.  A status other than OST_OK ends the take.
 */
typedef ost_status ost_live_visit(void *user, const int32_t at[3], const uint32_t *words, ost_error *err);

/*
 * Calls visit for every chunk that changed since the last take, or for all chunks the first time.  If visit ends the
 * take, the remaining chunks are part of the next one.  Returns the status of visit.
 */
OST_API ost_status ost_live_take(ost_live_channel *live, ost_live_visit *visit, void *user, ost_error *err);
/* Returns the bone's geometry; valid until the live state is freed. */
OST_API const ost_geometry *ost_live_geometry(const ost_live_channel *live);
/* Returns the edge length of the bone's chunks in voxels. */
OST_API int ost_live_chunk_size(const ost_live_channel *live);

#ifdef __cplusplus
}
#endif
#endif
