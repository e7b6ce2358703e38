/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thresholds for the size of work.  For large work, the CPU backend enters code paths that divide the
 * work among threads, use stores that bypass the caches, or split the work into parts.  Each path has
 * a threshold and a counter.
 *
 *   path, size of the work --ost_cpu_enters--> true and counted if size >= the path's threshold
 *
 *   ost_team team = ost_team_of(sharing, threads, OST_PATH_LEAVES, count, count, 8);
 *   #pragma omp parallel num_threads(team.threads)
 *   {
 *       ost_member me = ost_team_join(&team);
 *       for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;)
 *           ...
 *   }
 *   ost_team_end(sharing, &team);
 *
 * A threshold affects the speed of a computation, never its result.  The `grain` option replaces all
 * thresholds with one number, so that small grids enter every path.  Items are then assigned to the
 * threads in turn, one at a time, so that each thread of a team processes items even if it starts
 * late.
 *
 * With the option order=N, the seed N determines the order in which blocks are assigned, and between
 * which blocks a thread pauses.  This option is used to find data races: a race that does not show in
 * one schedule may show in another.  The option does not change any result.
 *
 * ost_backend_paths (core/paths.h) reports the counters.
 */
#ifndef OST_CPU_SHARE_H
#define OST_CPU_SHARE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/backend.h"

typedef enum ost_cpu_path {
    /* paths that divide work among threads */
    OST_PATH_SCATTER,
    OST_PATH_GRID_UPLOAD,
    OST_PATH_GRID_COPY,
    OST_PATH_CHUNKS,
    OST_PATH_BONE_UPLOAD,
    OST_PATH_LEAVES,
    OST_PATH_SORT,
    OST_PATH_TILES,
    OST_PATH_TOOL_DOWNLOAD,
    OST_PATH_REMOVAL,
    OST_PATHS_SHARED,
    /* paths that do not depend on the number of threads */
    OST_PATH_BLOCKS = OST_PATHS_SHARED,
    OST_PATH_MAPPED,
    OST_PATH_LAYERS,
    OST_PATH_CHUNK_STREAM,
    OST_PATH_TOOL_STREAM,
    OST_PATH_TILED,
    OST_CPU_PATHS
} ost_cpu_path;

typedef struct ost_cpu_sharing {
    int64_t least[OST_CPU_PATHS]; /* for each path, the smallest size of work with which the path is entered */
    /* true if the option `grain` or `order` was given; blocks are then assigned to the members in turn */
    bool dealt;
    /* value of the `order` option, the seed of the random order; 0 if the option was not given */
    uint64_t order;
    /* number of teams started with the option `order`; each team's random order depends on this number */
    uint64_t teams;
    /* number of times each path was entered; ost_team_end counts the paths that divide work */
    uint64_t entered[OST_CPU_PATHS];
} ost_cpu_sharing;

/* Initialises *sharing. If grain is 0, the measured thresholds are used; if order is 0, blocks have the usual order. */
void ost_cpu_sharing_init(ost_cpu_sharing *sharing, int64_t grain, uint64_t order);
/* Calls visit for each path that a backend with this number of threads can enter. */
void ost_cpu_sharing_visit(const ost_cpu_sharing *sharing, int threads, ost_path_visit *visit, void *user);

/* Returns true if work of this size enters the path; if so, increments the path's counter.  Called by one thread at
   a time. */
static inline bool ost_cpu_enters(ost_cpu_sharing *sharing, ost_cpu_path path, int64_t size)
{
    if (size < sharing->least[path])
        return false;
    sharing->entered[path]++;
    return true;
}

/* A team of threads (its members) and its work: the items [0, count), divided into blocks. */
typedef struct ost_team {
    int threads; /* requested from OpenMP */
    ost_cpu_path path;
    /* true if block b is processed by member b mod members; false if it is processed by the next free member */
    bool dealt;
    /* number of all items, and number of items per block */
    int64_t count, block;
    /* with a random order, the number of blocks begun by members; otherwise, if `dealt` is false, the next block */
    _Atomic int64_t next;
    uint64_t order;       /* seed of the team's random order; 0 for the usual order */
    /* with a random order, turn t is for the block (first + t * stride) mod (number of blocks) */
    int64_t first, stride;
    int members;          /* number of threads that OpenMP provided; valid after the parallel region */
} ost_team;

typedef struct ost_member {
    int64_t at, end;      /* the remaining items of the member's current block, at <= item < end */
    /*
     * if `dealt` is true, `next` is the member's next block, and `stride` is the distance between the member's blocks
     */
    int64_t next, stride;
} ost_member;

/*
 * Returns a team for `count` items, which are divided into blocks of the length `block`. If block is 0,
 * there is one block per member. `size` is the size of the work in the path's unit.
 */
ost_team ost_team_of(ost_cpu_sharing *sharing, int threads, ost_cpu_path path, int64_t size, int64_t count,
                     int64_t block);
/* Makes the calling thread a member of the team and returns the member. Every thread of the parallel region must call
   this function. */
ost_member ost_team_join(ost_team *team);
/*
 * Increments the counter of the team's path if every thread of the team processed items. Called after the parallel
 * region.
 */
void ost_team_end(ost_cpu_sharing *sharing, const ost_team *team);

/*
 * Waits for a time that depends on the team's random order, and returns the block that the member processes in this
 * turn.
 */
int64_t ost_team_block(ost_team *team, const ost_member *me, int64_t turn);

/* Returns the member's next item, or -1 after the last item. */
static inline int64_t ost_team_next(ost_team *team, ost_member *me)
{
    if (me->at < me->end)
        return me->at++;
    int64_t block = me->next;
    if (team->dealt) {
        me->next += me->stride;
        if (team->order && block * team->block < team->count)
            block = ost_team_block(team, me, block);
    } else
        block = atomic_fetch_add_explicit(&team->next, 1, memory_order_relaxed);
    if (block * team->block >= team->count)
        return -1;
    me->at = block * team->block;
    me->end = team->count - me->at < team->block ? team->count : me->at + team->block;
    return me->at++;
}

#endif
