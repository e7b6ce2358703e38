/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Grids of the CPU backend: voxels, and which of them are seen.
 *
 *   rect grid    ----.                     .--> voxels, held by both
 *                     >-- cpu_store ------<
 *   cubic grid   ----'    256 x 234 x 201
 *    map z: 0 0 1 1 2 3 3 4 ... (428)
 *
 * A resampled grid repeats and leaves out voxels of another and changes none,
 * so it is that grid's store and three ascending lists of indices.  Chunks are
 * made from it straight away; a grid of its own comes to be only when somebody
 * writes to it.  A store with several holders is never written to.
 */
#ifndef OST_CPU_GRID_H
#define OST_CPU_GRID_H

#include "cpu/cpu.h"

typedef struct cpu_store {
    int holders;
    bool mapped;     /* by mmap, else malloc */
    ost_dims dims;
    size_t bytes;
    int16_t *voxels; /* owned */
} cpu_store;

typedef struct cpu_grid {
    ost_grid base;
    cpu_store *store; /* held */
    int32_t *map[3];  /* owned; voxel i of an axis is map[i] of the store's; all three NULL: they are the same */
    uint8_t *seen;    /* owned; a bit a voxel, NULL before the first scatter */
} cpu_grid;

/* Voxels as an axis-wise selection of dense rows; what grids and a caller's slices have in common. */
typedef struct cpu_view {
    const int16_t *voxels;
    size_t row, slice;     /* elements from one to the next */
    const int32_t *map[3]; /* each may be NULL: i is i */
} cpu_view;

cpu_view ost_cpu_grid_view(const cpu_grid *grid);
/* Copies voxels [x0, x0 + width) of row (y, z), width any. */
void ost_cpu_view_row(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t x0, int32_t width, int32_t y, int32_t z, int16_t *to);

/* A grid that selects from `from`. maps are taken over, also on failure. */
ost_status ost_cpu_grid_select(const cpu_grid *from, const ost_geometry *geometry, int32_t *map[3], ost_grid **out, ost_error *err);
/* Gives the grid a store that it alone holds, with its voxels in their places. */
ost_status ost_cpu_grid_own(cpu_grid *grid, ost_error *err);

ost_status ost_cpu_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
void ost_cpu_grid_free(ost_grid *grid);
ost_status ost_cpu_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cpu_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

#endif
