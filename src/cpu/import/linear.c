/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes rows of an interpolated grid (AR-CUB-2), up to 4 x 4 at a time.
 *
 *   z only        a row is computed from one row in each of two slices     blend_rows
 *   other axes    up to 8 x 8 source rows are interpolated along x         stretch_row
 *                 a row is computed from one, two or four of these rows    weigh_rows
 *
 * All sums are exact integers, so their order does not matter, and a result is
 * rounded once, at the end.
 */
#include "core/conditions.h"
#include "cpu/import/grid.h"

#include <string.h>

enum { SOURCES = 8 };

/* The distinct offsets of several taps, in ascending order. Offset i of tap t is from[of[t][i]]. */
typedef struct sources {
    size_t from[SOURCES];
    int count;
    int of[4][2];
} sources;

/*
 * Lists the distinct offsets of the taps. Because the taps ascend, an offset is either new or one of the last two
 * offsets in the list.
 */
static sources sources_of(const cpu_tap *taps, int count)
{
    sources s = {.count = 0};
    for (int t = 0; t < count; t++)
        for (int i = 0; i < taps[t].count; i++) {
            if (s.count == 0 || taps[t].from[i] > s.from[s.count - 1])
                s.from[s.count++] = taps[t].from[i];
            s.of[t][i] = taps[t].from[i] == s.from[s.count - 1] ? s.count - 1 : s.count - 2;
        }
    return s;
}

static void between_slices(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t x0, int32_t width,
                           const cpu_tap *y, int ny, const cpu_tap *z, int nz, int16_t (*to)[OST_ROW_STRIDE])
{
    size_t row[4];
    for (int j = 0; j < ny; j++)
        row[j] = y[j].from[0];
    for (int k = 0; k < nz; k++) {
        const int16_t *const lower = view->voxels + z[k].from[0] + x0;
        if (z[k].count == 2)
            kernels->blend_rows(lower, view->voxels + z[k].from[1] + x0, row, ny, width, -z[k].minus[1], to[4 * k]);
        for (int j = 0; j < ny && z[k].count == 1; j++)
            memcpy(to[4 * k + j], lower + row[j], (size_t)width * sizeof to[0][0]);
    }
}

static void stretch(const cpu_view *view, const ost_cpu_kernels *kernels, const int16_t *row, int32_t x0, int32_t width,
                    int32_t *to)
{
    if (view->row > 1)
        kernels->stretch_row(row, view->map[0] + x0, view->minus[0] + 2 * (size_t)x0, width, to);
    for (int32_t i = 0; i < width && view->row == 1; i++) /* a row of a single voxel cannot be interpolated along x */
        to[i] = row[0] * -OST_WEIGHT_ONE;
}

void ost_cpu_linear_rows(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t x0, int32_t width,
                         const cpu_tap *y, int ny, const cpu_tap *z, int nz, int16_t (*to)[OST_ROW_STRIDE])
{
    _Alignas(64) int32_t sums[SOURCES][SOURCES][OST_ROW_STRIDE];
    if (!view->minus[0]) {
        between_slices(view, kernels, x0, width, y, ny, z, nz, to);
        return;
    }
    const sources rows = sources_of(y, ny), slices = sources_of(z, nz);
    for (int k = 0; k < slices.count; k++)
        for (int j = 0; j < rows.count; j++)
            stretch(view, kernels, view->voxels + slices.from[k] + rows.from[j], x0, width, sums[k][j]);
    for (int k = 0; k < nz; k++)
        for (int j = 0; j < ny; j++) {
            const int32_t *of[4] = {NULL};
            int32_t weight[4] = {0};
            int count = 0;
            for (int b = 0; b < z[k].count; b++)
                for (int a = 0; a < y[j].count; a++) {
                    of[count] = sums[slices.of[k][b]][rows.of[j][a]];
                    /* The product, at most 2^30, is negated, because the weights of the sums along x are negated. */
                    weight[count++] = -(y[j].minus[a] * z[k].minus[b]);
                }
            kernels->weigh_rows(of, weight, count, width, to[4 * k + j]);
        }
}
