/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The CPU backend: results bit-identical to the reference's, computed with the
 * machine's instruction sets and threads.
 *
 *   cpu.c       the table, options "isa=", "threads=", "grain=", "order=" and "voxelizer="
 *   share.c     division of work among threads: thresholds and counters
 *   kernels.c   the inner loops, chosen once at open
 *   tool.c      tools, with the tables that removal uses
 *   import/     samples -> rect -> cubic -> chunks; grid.c: grids, resampled ones as lists of indices
 *   bone/       chunks of bricks: upload and download of slices, leaves
 *   remove/     removal and collision; shape.c: a tool's distances and windows
 *   voxelize/   snapped mesh -> tool grid (voxelize.h; embree.h)
 *
 * The objects embed those of the reference, so an operation without a fast implementation uses the
 * reference's function. Each thread processes complete chunks, slices or tiles, and no two threads
 * write the same data; results are put in order afterwards.
 */
#ifndef OST_CPU_CPU_H
#define OST_CPU_CPU_H

#include "core/isa.h"
#include "cpu/bone/chunk_pool.h"
#include "cpu/kernels.h"
#include "cpu/ref/ref.h"
#include "cpu/remove/event.h"
#include "cpu/share.h"

/* The method that finds a mesh's crossings; the resulting grid is the same. */
typedef enum ost_voxelizer { OST_VOXELIZER_AUTO, OST_VOXELIZER_TRIANGLES, OST_VOXELIZER_EMBREE } ost_voxelizer;

typedef struct cpu_backend {
    ref_backend ref; /* first member, because the reference's functions are called with this object */
    ost_isa isa;
    int threads; /* >= 1 */
    ost_voxelizer voxelizer;
    ost_cpu_sharing *sharing; /* owned */
    ost_cpu_kernels kernels;
    ost_event_scratch event;
    ost_chunk_pool *pools[3]; /* owned; for chunks of 16, 32 and 64 voxels per side; NULL before the first such bone */
} cpu_backend;

#endif
