/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a running operation shows: from the tick to one thread that looks on,
 * a renderer for instance.
 *
 *   tick    --ost_live_changed--> chunks that wait --ost_live_publish, a few a tick--> words, a dirty bit a chunk
 *           --ost_live_publish--> the state: poses, force, counts
 *   looker  <--ost_live_state_get-- the newest state
 *           <--ost_live_take-- every chunk that changed since the last take
 *
 * Wait-free on both sides: no lock, no memory, no call of the system, and no
 * loop that another thread could make longer.  A looker that is slow, or never
 * comes, costs the tick nothing: a chunk that changes again before it was
 * looked at is one change.  Nothing is lost: when the tick is done and all is
 * flushed, what was taken is the bone, to the bit.  Before that a chunk may be
 * seen between two of its states; bone only ever goes, so that is bone that
 * was there a moment ago, and the next take brings the rest.
 *
 * The words are copied from the backend by ost_bone_occupancy: `cpu` and `ref`
 * give them as a tick needs it; of `cl` a device is read and waited for, as a
 * removal waits for its report; `plugin` has none to give, and there is no
 * ost_live.
 *
 * Threads: changed, publish and flush are the tick's; state_get and take those
 * of one thread that looks on.  The others when neither is at work.
 */
#ifndef OSTEON_LIVE_H
#define OSTEON_LIVE_H

#include <osteon/backend.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_live ost_live;

enum { OST_LIVE_TOOLS = 16 };

typedef struct ost_live_state {
    uint64_t ticks;         /* that were done, 0: none yet */
    int64_t t_ns;           /* of the last */
    int32_t tool;           /* in use */
    int32_t rpm;            /* of its motor (path.h) */
    ost_pose device, pose;  /* where the hand is; where the tool is, which a force may hold back */
    double force_n[3], torque_nm[3]; /* hand force and torque: of the device on the hand */
    double contact_n;       /* contact force: of the tool on the bone */
    double reached_mm[OST_LIVE_TOOLS]; /* by tool: the deepest that it removed bone, as options.depth_of (operation.h) has it; 0 before */
    uint64_t removals, removed_voxels;
    uint64_t missed;        /* ticks that were skipped */
    uint32_t wake_ns, exec_ns; /* of the last tick: how late it was, what it took */
    uint32_t touching;      /* bone voxels that the tool touched or removed in it */
    int32_t fault;          /* an ost_fault (operation.h); 0: none */
    bool declared;          /* the device gave no new pose */
} ost_live_state;

/* Holds a bit for every voxel of the bone's active chunks. The bone is borrowed, and must not grow. */
OST_API ost_status ost_live_create(const ost_bone *bone, ost_live **out, ost_error *err);
OST_API void ost_live_free(ost_live *live); /* NULL is allowed */

/* ------------------------------------------------------------- the tick's */

/* The chunks of an event; NULL is allowed, for a tick without one. */
OST_API void ost_live_changed(ost_live *live, const ost_report *report);
/* State, and some 8 kB of chunks that wait: two of 32^3 voxels. On an error, the backend's, they wait on. */
OST_API ost_status ost_live_publish(ost_live *live, const ost_live_state *state, ost_error *err);
/* All chunks that wait; for the end, or a pause. */
OST_API ost_status ost_live_flush(ost_live *live, ost_error *err);

/* --------------------------------------------------- the other thread's */

/* False when there is none yet; the newest, perhaps one that was had before. */
OST_API bool ost_live_state_get(ost_live *live, ost_live_state *out);

/* Of a chunk, in chunks; words as ost_bone_occupancy has them, until visit returns. Not OST_OK ends the take. */
typedef ost_status ost_live_visit(void *user, const int32_t at[3], const uint32_t *words, ost_error *err);

/* Every chunk that changed since the last take, all of them the first time; of a take that a visit ended, the rest comes with the next. */
OST_API ost_status ost_live_take(ost_live *live, ost_live_visit *visit, void *user, ost_error *err);
/* Of the bone. */
OST_API const ost_geometry *ost_live_geometry(const ost_live *live);
OST_API int ost_live_chunk_size(const ost_live *live);

#ifdef __cplusplus
}
#endif
#endif
