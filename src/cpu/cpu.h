/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The CPU backend. It uses the machine's instruction sets and threads; its results are bit-identical to the results of
 * the reference.
 *
 *   cpu.c       the function table; options "isa=", "threads=", "grain=", "order=" and "voxelizer="
 *   share.c     division of work among threads: thresholds and counters
 *   kernels.c   the inner loops, chosen once when the backend is opened
 *   tool.c      tools as bits, with the tables that removal uses
 *   import/     samples -> rect -> cubic -> chunks; grid.c: grids
 *   bone/       chunks of bricks: upload and download of slices, leaves
 *   remove/     removal and collision; shape.c: a tool's distances and windows
 *   face_mesh.c visible faces of chunks as quads
 *   voxelize/   snapped mesh -> tool grid (voxelize.h; embree.h)
 *
 * The structs of this backend, except tools, begin with the structs of the reference. The reference's functions can
 * therefore be used for operations that have no fast implementation. Each thread processes complete chunks, slices or
 * tiles, and no two threads write the same data. The reports of the threads are sorted afterwards.
 */
#ifndef OST_CPU_CPU_H
#define OST_CPU_CPU_H

#include "core/isa.h"
#include "cpu/bone/chunk_pool.h"
#include "cpu/kernels.h"
#include "cpu/ref/ref.h"
#include "cpu/remove/event.h"
#include "cpu/share.h"

/* The method that finds the crossings of a mesh with the rows of a grid. The resulting grid does not depend on the
   method. */
typedef enum ost_voxelizer { OST_VOXELIZER_AUTO, OST_VOXELIZER_TRIANGLES, OST_VOXELIZER_EMBREE } ost_voxelizer;

typedef struct cpu_backend {
    /* must be the first member, because a pointer to this struct is passed to the reference's functions */
    ref_backend ref;
    ost_isa isa;
    int threads; /* >= 1 */
    ost_voxelizer voxelizer;
    ost_cpu_sharing *sharing; /* owned */
    ost_cpu_kernels kernels;
    ost_event_scratch event;
    /* owned pools for chunks of 16, 32 and 64 voxels per side; NULL before the first use */
    ost_chunk_pool *pools[3];
} cpu_backend;

#endif
