/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Grids of the CPU backend: views of stored voxels.
 *
 *   rect grid    ----.                     .--> voxels, shared by both
 *                     >-- cpu_store ------<
 *   cubic grid   ----'    256 x 234 x 201
 *    map z: 0 0 1 1 2 3 3 4 ... (428)
 *
 * A resampled grid shares the store of the grid from which it was created. It has a list of ascending indices for each
 * axis, and a list of weights for each axis that is interpolated. Chunks are computed from the store and the lists. A
 * store that is shared by several grids is never written to. If voxels are written to a resampled grid, or if an
 * interpolation needs neighbours that are not adjacent in the shared store, the grid is copied to a store of its own.
 */
#ifndef OST_CPU_GRID_H
#define OST_CPU_GRID_H

#include "cpu/cpu.h"

typedef struct cpu_store {
    int holders;
    bool mapped;     /* true if the voxels were allocated with mmap; false if they were allocated with calloc */
    ost_dims dims;
    size_t bytes;
    int16_t *voxels; /* owned */
} cpu_store;

typedef struct cpu_grid {
    ost_grid base;
    cpu_store *store; /* the store that contains the voxels; other grids may share it */
    /* owned lists; on axis a, voxel i of the grid is voxel map[a][i] of the store; all NULL if the grid has no lists */
    int32_t *map[3];
    int16_t *minus[3]; /* owned lists of negated weights, in the format of cpu_view */
    /* owned bit array with one bit per voxel, 1 if the voxel has a sample; NULL before the first batch of samples */
    uint8_t *seen;
} cpu_grid;

/*
 * The voxels of a grid, defined on each axis by the voxels of a store:
 *
 *   axis without weights   voxel i is voxel map[i] of the store
 *   axis with weights      voxel i is the mean of the store's voxels map[i] and map[i] + 1 with the weights
 *                          -minus[2i] / 2^15 and -minus[2i + 1] / 2^15
 *
 * A voxel with weight 0 may lie outside the store, with one exception: along x, both voxels lie in the store if the
 * store has two or more voxels along x. The capacity of lists along x is a multiple of 16.
 *
 * There are three kinds of view. In the first, no axis has weights, and all elements of minus[] are NULL. In the
 * second, only z has weights, and the x and y coordinates are those of the store. In the third, x and possibly other
 * axes have weights.
 */
typedef struct cpu_view {
    const int16_t *voxels;
    size_t row, slice;     /* distances in elements: between adjacent rows, and between adjacent slices */
    /* index lists of the axes; all NULL if voxel (x, y, z) of the view is voxel (x, y, z) of the store */
    const int32_t *map[3];
    const int16_t *minus[3];
} cpu_view;

/*
 * The sources from which a row (axis 1) or a slice (axis 2) of a grid is computed. `from` contains the offsets of one
 * or two rows or slices of the store, and `minus` their negated weights. The negated weights are in [-2^15, -1] and sum
 * to -2^15.
 */
typedef struct cpu_tap {
    size_t from[2];
    int32_t minus[2];
    int count;
} cpu_tap;

static inline cpu_tap ost_cpu_view_tap(const cpu_view *view, int axis, int32_t i)
{
    const size_t step = axis == 1 ? view->row : view->slice;
    const size_t at = (size_t)(view->map[axis] ? view->map[axis][i] : i) * step;
    const int16_t *const minus = view->minus[axis] ? view->minus[axis] + 2 * (size_t)i : NULL;
    if (!minus || minus[1] == 0)
        return (cpu_tap){{at}, {-OST_WEIGHT_ONE}, 1};
    if (minus[0] == 0)
        return (cpu_tap){{at + step}, {-OST_WEIGHT_ONE}, 1};
    return (cpu_tap){{at, at + step}, {minus[0], minus[1]}, 2};
}

static inline bool ost_cpu_view_linear(const cpu_view *view)
{
    return view->minus[0] || view->minus[2];
}

/*
 * Computes the voxels [x0, x0 + width) of ny rows in each of nz slices of a view that has weights. Row j of slice k is
 * written to the array to[4 k + j]. Requires width <= 64, ny <= 4, nz <= 4, an x0 that is a multiple of 16, and taps in
 * ascending order. Elements of a row of `to` beyond width may be overwritten.
 */
void ost_cpu_linear_rows(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t x0, int32_t width,
                         const cpu_tap *y, int ny, const cpu_tap *z, int nz, int16_t (*to)[OST_ROW_STRIDE]);

cpu_view ost_cpu_grid_view(const cpu_grid *grid);

/* Creates a grid that shares the store of `from`. The function takes ownership of map and minus, also on failure. */
ost_status ost_cpu_grid_select(const cpu_grid *from, const ost_geometry *geometry, int32_t *map[3], int16_t *minus[3],
                               ost_grid **out, ost_error *err);
/* Ensures that the grid does not share its store, and that the store contains exactly the grid's voxels. */
ost_status ost_cpu_grid_own(cpu_grid *grid, ost_error *err);

ost_status ost_cpu_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
void ost_cpu_grid_free(ost_grid *grid);
ost_status ost_cpu_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cpu_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

#endif
