/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/share.h"

#include <sched.h>
#include <stdio.h>

#if defined _OPENMP
#include <omp.h>
#endif

/*
 * The measured thresholds of all paths (docs/log/0.1.md). The comment of each row states the unit
 * of its threshold. Starting a second thread takes microseconds, or milliseconds if the thread has
 * to wait for a core that another process uses.
 */
static const struct {
    const char *name;
    int64_t least;
} paths[OST_CPU_PATHS] = {
    [OST_PATH_SCATTER] = {"scatter", 1 << 16},            /* samples per block */
    [OST_PATH_GRID_UPLOAD] = {"upload of a grid", 1 << 17},    /* voxels */
    [OST_PATH_GRID_COPY] = {"copy of a grid", 1 << 17},       /* voxels */
    [OST_PATH_CHUNKS] = {"conversion to chunks", 1 << 17},          /* voxels */
    [OST_PATH_BONE_UPLOAD] = {"upload of a bone", 8},          /* slices */
    [OST_PATH_LEAVES] = {"digest", 64},                   /* leaves */
    [OST_PATH_SORT] = {"sort of triangles", 4096},            /* triangles per part */
    [OST_PATH_TILES] = {"voxelization", 1000000},         /* estimated nanoseconds */
    [OST_PATH_TOOL_DOWNLOAD] = {"download of a tool", 1 << 17},    /* voxels */
    /* in voxels, summed over all chunks of the event */
    [OST_PATH_REMOVAL] = {"removal and collision", 1 << 22},
    [OST_PATH_BLOCKS] = {"scatter in several blocks", (1 << 16) + 1},       /* samples per call */
    /* in bytes; larger grids are mapped, so that the system can use huge pages */
    [OST_PATH_MAPPED] = {"grid in mapped memory", 1 << 22},
    [OST_PATH_LAYERS] = {"conversion in several parts", (1 << 14) + 1},  /* chunks */
    /* in bytes; larger chunks would not stay in the caches anyway */
    [OST_PATH_CHUNK_STREAM] = {"chunks written past the caches", (8 << 20) + 1},
    /* in voxels; larger tools would not stay in the caches anyway */
    [OST_PATH_TOOL_STREAM] = {"tool written past the caches", 1 << 25},
    /*
     * in bytes; if a grid has several tiles, the two planes of each tile together are smaller than this threshold and
     * fit in the L2 cache
     */
    [OST_PATH_TILED] = {"voxelization in several tiles", (1 << 19) + 1},
};

void ost_cpu_sharing_init(ost_cpu_sharing *sharing, int64_t grain, uint64_t order)
{
    *sharing = (ost_cpu_sharing){.dealt = grain > 0 || order > 0, .order = order};
    for (int p = 0; p < OST_CPU_PATHS; p++)
        sharing->least[p] = grain > 0 ? grain : paths[p].least;
}

void ost_cpu_sharing_visit(const ost_cpu_sharing *sharing, int threads, ost_path_visit *visit, void *user)
{
    for (int p = threads > 1 ? 0 : OST_PATHS_SHARED; p < OST_CPU_PATHS; p++) {
        char name[OST_PATH_NAME];
        if (p < OST_PATHS_SHARED)
            snprintf(name, sizeof name, "%s on %d threads", paths[p].name, threads);
        else
            snprintf(name, sizeof name, "%s", paths[p].name);
        visit(user, name, sharing->entered[p]);
    }
}

/* splitmix64 */
static uint64_t mixed(uint64_t x)
{
    x += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

static int64_t common_divisor(int64_t a, int64_t b)
{
    while (b) {
        const int64_t remainder = a % b;
        a = b;
        b = remainder;
    }
    return a;
}

/* Draws a random order in which a team processes its blocks: a first block and a stride. The stride is coprime with
   the number of blocks, so each block is visited once. */
static void draw_order(ost_cpu_sharing *sharing, ost_team *team)
{
    const int64_t blocks = (team->count + team->block - 1) / team->block;
    team->order = mixed(sharing->order ^ mixed(sharing->teams++)) | 1;
    team->stride = 1;
    if (blocks < 2 || blocks > INT32_MAX)
        return;
    team->first = (int64_t)(team->order >> 33) % blocks;
    team->stride = 1 + (int64_t)(mixed(team->order) >> 33) % (blocks - 1);
    while (common_divisor(team->stride, blocks) != 1)
        team->stride--;
}

/*
 * Depending on the seed, the calling member yields its core, continues immediately, or waits until all members have
 * begun as many blocks as this member. The wait makes all members run at the same time.
 */
int64_t ost_team_block(ost_team *team, const ost_member *me, int64_t turn)
{
    enum { TRIES = 20000 }; /* maximum number of polls, which take tens of microseconds in total */
    const int64_t blocks = (team->count + team->block - 1) / team->block, round = turn / me->stride;
    const uint64_t drawn = mixed(team->order + (uint64_t)turn);
    const int64_t all = (round + 1) * me->stride;
    atomic_fetch_add_explicit(&team->next, 1, memory_order_relaxed);
    if (drawn % 4 != 0 && all <= blocks)
        for (int i = 0; i < TRIES && atomic_load_explicit(&team->next, memory_order_relaxed) < all; i++)
            if (i % 1024 == 1023)
                sched_yield();
    for (uint64_t i = drawn >> 8 & 3; drawn % 4 == 0 && i > 0; i--)
        sched_yield();
    return (team->first + turn * team->stride) % blocks;
}

ost_team ost_team_of(ost_cpu_sharing *sharing, int threads, ost_cpu_path path, int64_t size, int64_t count,
                     int64_t block)
{
    ost_team team = {.threads = size < sharing->least[path] ? 1 : threads,
                     .path = path,
                     .dealt = sharing->dealt || block == 0,
                     .count = count,
                     .members = 1};
    team.block = block == 0 ? (count + team.threads - 1) / team.threads : sharing->dealt ? 1 : block;
    team.block = team.block > 0 ? team.block : 1;
    if (sharing->order && team.threads > 1)
        draw_order(sharing, &team);
    return team;
}

ost_member ost_team_join(ost_team *team)
{
#if defined _OPENMP
    if (omp_get_thread_num() == 0)
        team->members = omp_get_num_threads();
    return (ost_member){.next = omp_get_thread_num(), .stride = omp_get_num_threads()};
#else
    (void)team;
    return (ost_member){.stride = 1};
#endif
}

void ost_team_end(ost_cpu_sharing *sharing, const ost_team *team)
{
    const int64_t blocks = (team->count + team->block - 1) / team->block;
    if (team->threads > 1 && team->members == team->threads && blocks >= team->members)
        sharing->entered[team->path]++;
}
