/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The CPU backend: the reference's results, to the bit, as fast as this
 * machine gives them.
 *
 *   cpu.c       the table, options "isa=", "threads=", "grain=" and "voxelizer="
 *   share.c     thresholds of what threads share, and counters
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
#include "cpu/share.h"

/* Who finds a mesh's crossings; the grid is the same. */
typedef enum ost_voxelizer { OST_VOXELIZER_AUTO, OST_VOXELIZER_TRIANGLES, OST_VOXELIZER_EMBREE } ost_voxelizer;

typedef struct cpu_backend {
    ref_backend ref; /* first: the reference's functions run on it */
    ost_isa isa;
    int threads; /* >= 1 */
    ost_voxelizer voxelizer;
    ost_cpu_sharing *sharing; /* owned */
    ost_cpu_kernels kernels;
    ost_event_scratch event;
    ost_chunk_pool *pools[3]; /* owned; for chunks of 16, 32, 64, NULL before the first */
} cpu_backend;

#endif
