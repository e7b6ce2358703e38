/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thresholds for the size of work. From a threshold on, the CPU backend divides the work among
 * threads, writes past the caches or splits the work into parts. Each threshold has a counter.
 *
 *   path, size of the work --ost_cpu_enters--> true from the path's threshold on, and it is counted
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
 * A threshold affects the speed of a computation, never its result.  The option
 * grain= replaces all thresholds by one number, so that small grids enter every
 * path; items are then assigned to the threads in turn, one at a time, so that
 * each thread of a team gets its items even if it starts late.
 *
 * The option order=N assigns the blocks in another order and lets members pause between them, both
 * determined by the seed N, because a race that one schedule hides can appear in another. The
 * option does not change any result.
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
    /* Paths that divide work among threads. */
    OST_PATH_SCATTER,
    OST_PATH_GRID_UPLOAD,
    OST_PATH_GRID_COPY,
    OST_PATH_CHUNKS,
    OST_PATH_BONE_UPLOAD,
    OST_PATH_LEAVES,
    OST_PATH_SORT,
    OST_PATH_TILES,
    OST_PATH_REMOVAL,
    OST_PATHS_SHARED,
    /* Paths that do not depend on the number of threads. */
    OST_PATH_BLOCKS = OST_PATHS_SHARED,
    OST_PATH_MAPPED,
    OST_PATH_LAYERS,
    OST_PATH_CHUNK_STREAM,
    OST_PATH_TOOL_STREAM,
    OST_PATH_TILED,
    OST_CPU_PATHS
} ost_cpu_path;

typedef struct ost_cpu_sharing {
    int64_t least[OST_CPU_PATHS]; /* size of the work from which a path is entered */
    bool dealt;                   /* blocks are assigned in turn: grain= or order= was given */
    uint64_t order;               /* seed of order=; 0: none */
    uint64_t teams;               /* number of teams so far, counted only with order=; each has its own order */
    uint64_t entered[OST_CPU_PATHS]; /* shared paths are counted only if every thread processed a part */
} ost_cpu_sharing;

/* Initialises *sharing. grain is 0 for the measured thresholds; order is 0 for none. */
void ost_cpu_sharing_init(ost_cpu_sharing *sharing, int64_t grain, uint64_t order);
/* Visits the paths that a backend with this number of threads can enter. */
void ost_cpu_sharing_visit(const ost_cpu_sharing *sharing, int threads, ost_path_visit *visit, void *user);

/* Returns true if work of this size enters the path, which is counted.  Called by one thread at a time. */
static inline bool ost_cpu_enters(ost_cpu_sharing *sharing, ost_cpu_path path, int64_t size)
{
    if (size < sharing->least[path])
        return false;
    sharing->entered[path]++;
    return true;
}

/* Items [0, count), divided into blocks that the members of a team process. */
typedef struct ost_team {
    int threads; /* requested from OpenMP */
    ost_cpu_path path;
    bool dealt;  /* block b belongs to member b mod members; otherwise the next free member processes it */
    int64_t count, block; /* items in all and per block */
    _Atomic int64_t next; /* the next block, if not dealt; with an order: number of blocks begun */
    uint64_t order;       /* seed of this team; 0: none */
    int64_t first, stride; /* with an order: in turn t, block (first + t stride) mod blocks is processed */
    int members;          /* number of threads that OpenMP provided; valid after the region */
} ost_team;

typedef struct ost_member {
    int64_t at, end;      /* remaining items of the current block */
    int64_t next, stride; /* if dealt: this member's next block, and the distance to the one after it */
} ost_member;

/*
 * Returns a team for count items in blocks of `block` items; if block is 0, each member processes
 * one block. size is the size of the work in the path's unit.
 */
ost_team ost_team_of(ost_cpu_sharing *sharing, int threads, ost_cpu_path path, int64_t size, int64_t count,
                     int64_t block);
/* Returns the calling thread's member; every thread of the parallel region must call it. */
ost_member ost_team_join(ost_team *team);
/* Counts the path as entered if every thread processed a part. Called after the parallel region. */
void ost_team_end(ost_cpu_sharing *sharing, const ost_team *team);

/* Pauses according to the order, then returns the block of this turn of a member. */
int64_t ost_team_block(ost_team *team, const ost_member *me, int64_t turn);

/* Returns the member's next item, -1 after the last. */
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
