/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/share.h"

#include <stdio.h>

#if defined _OPENMP
#include <omp.h>
#endif

/*
 * Measured (docs/performance.md).  A second thread costs microseconds to start,
 * and milliseconds where it has to wait for a core that another process uses.
 */
static const struct {
    const char *name;
    int64_t least;
} paths[OST_CPU_PATHS] = {
    [OST_PATH_SCATTER] = {"scatter", 1 << 16},            /* samples of a block */
    [OST_PATH_GRID_UPLOAD] = {"upload of a grid", 1 << 17},    /* voxels */
    [OST_PATH_GRID_COPY] = {"copy of a grid", 1 << 17},       /* voxels */
    [OST_PATH_CHUNKS] = {"conversion to chunks", 1 << 17},          /* voxels */
    [OST_PATH_BONE_UPLOAD] = {"upload of a bone", 8},          /* slices */
    [OST_PATH_LEAVES] = {"digest", 64},                   /* leaves */
    [OST_PATH_SORT] = {"sort of triangles", 4096},            /* triangles of a part */
    [OST_PATH_TILES] = {"voxelization", 1000000},         /* estimated nanoseconds */
    [OST_PATH_REMOVAL] = {"removal and collision", 1 << 22},            /* voxels of an event's chunks */
    [OST_PATH_BLOCKS] = {"scatter in several blocks", (1 << 16) + 1},       /* samples of a batch */
    [OST_PATH_MAPPED] = {"grid in mapped memory", 1 << 22},                /* bytes; huge pages pay from here on */
    [OST_PATH_LAYERS] = {"conversion in several parts", (1 << 14) + 1},  /* chunks */
    [OST_PATH_CHUNK_STREAM] = {"chunks written past the caches", (8 << 20) + 1}, /* bytes that do not fit the caches */
    [OST_PATH_TOOL_STREAM] = {"tool written past the caches", 1 << 25},         /* voxels of a tool that do not stay in a cache */
    [OST_PATH_TILED] = {"voxelization in several tiles", (1 << 19) + 1},    /* bytes of both planes, which a second cache holds */
};

void ost_cpu_sharing_init(ost_cpu_sharing *sharing, int64_t grain)
{
    *sharing = (ost_cpu_sharing){.dealt = grain > 0};
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

ost_team ost_team_of(const ost_cpu_sharing *sharing, int threads, ost_cpu_path path, int64_t size, int64_t count, int64_t block)
{
    ost_team team = {.threads = size < sharing->least[path] ? 1 : threads, .path = path, .dealt = sharing->dealt || block == 0, .count = count, .members = 1};
    team.block = block == 0 ? (count + team.threads - 1) / team.threads : sharing->dealt ? 1 : block;
    team.block = team.block > 0 ? team.block : 1;
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
