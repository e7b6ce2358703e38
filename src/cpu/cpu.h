/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The CPU backend: the reference's results, to the bit, as fast as this
 * machine gives them.
 *
 *   cpu.c       the table, options "isa=", "threads=" and "voxelizer="
 *   kernels.c   the inner loops, chosen once at open
 *   grid.c      grids, resampled ones as lists of indices
 *   import_*.c  samples -> rect -> cubic -> chunks
 *   bone.c      chunks of bricks: slices in and out, leaves
 *   remove.c    removal and collision, with shape.c: a tool's distances and windows
 *   voxelize.c  snapped mesh -> tool grid (voxelize.h; embree.h)
 *
 * Whatever has no fast form yet is the reference's own function: the objects
 * embed the reference's.  Threads take whole chunks, slices or columns and
 * share nothing they write; results are put in order afterwards.
 */
#ifndef OST_CPU_CPU_H
#define OST_CPU_CPU_H

#include "core/isa.h"
#include "cpu/bone/chunk_pool.h"
#include "cpu/kernels.h"
#include "cpu/ref/ref.h"
#include "cpu/remove/event.h"

/* Who finds a mesh's crossings; the grid is the same. */
typedef enum ost_voxelizer { OST_VOXELIZER_AUTO, OST_VOXELIZER_TRIANGLES, OST_VOXELIZER_EMBREE } ost_voxelizer;

/* Decide how fast a mesh becomes a grid, never what it is: tests make them small. */
typedef struct ost_vox_tuning {
    double threads_from_ns; /* estimated work that is worth more than one thread */
    int32_t plane_bytes;    /* of one plane of a tile; larger only when one row is */
} ost_vox_tuning;

/* The measured ones. */
extern const ost_vox_tuning ost_vox_tuning_default;

/* Voxels of an event's chunks from which on threads share it: below, starting them costs more than it gives (docs/performance.md). */
#define OST_EVENT_THREADED ((size_t)1 << 22)

typedef struct cpu_backend {
    ref_backend ref; /* first: the reference's functions run on it */
    ost_isa isa;
    int threads; /* >= 1 */
    ost_voxelizer voxelizer;
    ost_vox_tuning vox_tuning;
    size_t event_threaded; /* OST_EVENT_THREADED; tests make it 0 */
    ost_cpu_kernels kernels;
    ost_event_scratch event;
    ost_chunk_pool *pools[3]; /* owned; for chunks of 16, 32, 64, NULL before the first */
} cpu_backend;

#endif
