/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The live state of a running operation, passed from the servo thread to one
 * viewer thread, for instance a renderer.
 *
 *   servo thread  --ost_live_changed--> queue of chunks --ost_live_publish, some per tick--> words, dirty bit per chunk
 *                 --ost_live_publish--> the state: poses, force, counts
 *   viewer        <--ost_live_state_get-- the newest state
 *                 <--ost_live_take-- every chunk that changed since the last call
 *
 * Both threads are wait-free: they take no lock, allocate no memory and make no system call, and none of their
 * loops depends on the other thread. A slow or absent viewer adds no work to a tick: if a chunk changes twice
 * before the viewer takes it, the viewer takes the chunk only once. No change is lost: after the last tick and
 * ost_live_flush, the chunks taken are bit-identical to the bone. Before that, a chunk may be partly updated when
 * it is taken. Because bone is only removed, such a chunk may contain voxels that have just been removed; the next
 * call of ost_live_take corrects the chunk.
 *
 * ost_bone_occupancy copies the words from the backend. `cpu` and `ref` copy them fast enough for a tick. `cl` reads
 * them from the device and blocks until they arrive, as it does for the report of a removal. `plugin` cannot deliver
 * words of occupancy, so ost_live_create returns OST_ERR_UNAVAILABLE for it.
 *
 * Threads: ost_live_changed, ost_live_publish and ost_live_flush are called on the servo thread. ost_live_state_get and
 * ost_live_take are called on one viewer thread. ost_live_create and ost_live_free are called while neither thread uses
 * the object.
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
    uint64_t ticks;         /* number of ticks since the start */
    int64_t t_ns;           /* time of the last tick */
    int32_t tool;           /* index of the current tool */
    int32_t rpm;            /* speed of the current tool's motor (path.h) */
    ost_pose device, pose;  /* pose of the device and pose of the tool, which differ while the tool is in contact */
    double force_n[3], torque_nm[3]; /* hand force and hand torque, exerted by the device */
    double contact_n;       /* contact force of the tool on the bone */
    double reached_mm[OST_LIVE_TOOLS]; /* maximum depth at which each tool removed bone (depth_of in operation.h) */
    uint64_t removals, removed_voxels;
    uint64_t missed;        /* number of skipped ticks */
    uint32_t wake_ns, exec_ns; /* delay of the last tick's start, and duration of the last tick */
    uint32_t touching;      /* number of bone voxels that the tool touched or removed in the last tick */
    int32_t fault;          /* the current fault, an ost_fault (operation.h); 0 if there is none */
    bool declared;          /* true if the device returned no new pose in the last tick */
} ost_live_state;

/*
 * Creates the live state of a bone, with one bit for every voxel of the active chunks.  The bone must outlive the live
 * state and must not gain active chunks.  Returns OST_ERR_USAGE if bone is NULL, OST_ERR_UNAVAILABLE if the bone's
 * backend cannot deliver words of occupancy, OST_ERR_MEMORY if memory is exhausted, and backend errors (backend.h).
 * The caller frees *out with ost_live_free.
 */
OST_API ost_status ost_live_create(const ost_bone *bone, ost_live_channel **out, ost_error *err);
/* Frees a live state. NULL is allowed. */
OST_API void ost_live_free(ost_live_channel *live);

/* ----------------------------------------------------------- servo thread */

/* Queues the chunks that are listed in the report of an event. `report` may be NULL for a tick without an event. */
OST_API void ost_live_changed(ost_live_channel *live, const ost_removal_report *report);
/*
 * Publishes the state and about 8 kB of queued chunks (two chunks of 32^3 voxels). The errors are those of
 * ost_bone_occupancy; after an error, the chunks remain queued.
 */
OST_API ost_status ost_live_publish(ost_live_channel *live, const ost_live_state *state, ost_error *err);
/* Publishes all chunks that are still queued. Called at the end of an operation or during a pause. The errors are those
 * of ost_live_publish. */
OST_API ost_status ost_live_flush(ost_live_channel *live, ost_error *err);

/* ---------------------------------------------------------- viewer thread */

/*
 * Copies the newest state, which may be the state that the previous call copied. Returns false if no state has been
 * published.
 */
OST_API bool ost_live_state_get(ost_live_channel *live, ost_live_state *out);

/*
 * Receives the occupancy of one chunk. `at` is the index of the chunk along x, y and z. `words` has the layout of
 * ost_bone_occupancy and is valid until the function returns. If the function returns a status other than OST_OK,
 * ost_live_take visits no more chunks.
 */
typedef ost_status ost_live_visit(void *user, const int32_t at[3], const uint32_t *words, ost_error *err);

/*
 * Calls visit for every chunk that changed since the last call. The first call visits all active chunks. If visit
 * returns an error, the next call visits the remaining chunks. Returns the status that visit returned last, or OST_OK
 * if no chunk changed; the function itself has no errors. `visit` is called on the calling thread (ost_live_visit).
 */
OST_API ost_status ost_live_take(ost_live_channel *live, ost_live_visit *visit, void *user, ost_error *err);
/* Returns the geometry of the bone. The pointer is valid until the live state is freed. */
OST_API const ost_geometry *ost_live_geometry(const ost_live_channel *live);
/* Returns the edge length of the bone's chunks in voxels. */
OST_API int ost_live_chunk_size(const ost_live_channel *live);

#ifdef __cplusplus
}
#endif
#endif
