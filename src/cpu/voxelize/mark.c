/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Marks the crossings of one triangle with the rows of a tile, one crossing at a time.
 * This is the scalar kernel.  It is also used for triangles that the vector kernels do
 * not process.
 *
 * The triangle is oriented so that its projection on (y, z) runs
 * counter-clockwise (AR-VOX-1).  In slice k, the rows that the triangle owns are consecutive, because each edge a -> b
 * bounds them on one side. Let Y = j w + h, w = 2^f, h = w / 2, and t = 0 if the edge owns points with E = 0
 * (AR-VOX-2), otherwise t = 1. Then
 *
 *   E >= t   <=>   dz w j <= C,   C = dy (Z - az) + dz (ay - h) - t
 *
 *   dz > 0   j <= floor(C / (dz w))      dz < 0   j >= ceil(C / (dz w))
 *   dz = 0   all rows if C >= 0, otherwise none
 *
 * and in an owned row (AR-VOX-3), relative to a's voxel A = floor(ax / w),
 *
 *   i = A + ceil(M / (nx w)) = A + ceil(ceil(M / w) / nx)
 *   M = nx (ax - A w - h) - ny (Y - ay) - nz (Z - az)
 *
 * Proof that the quotients by doubles are exact.  Let m < N / D < m + 1 for an integer m. N / D differs from m and from
 * m + 1 by at least 1/D. The rounded quotient is the nearest double or, in other rounding modes, the next double below
 * or above. Because m and m + 1 are doubles, the rounded quotient is within [m, m + 1]. It is strictly inside if the
 * rounding error is less than 1/D. This error is at most half a unit in the last place or, in other rounding modes,
 * less than a unit. An integer quotient is a double and is not rounded.
 *   rows       |C| <= 2^43, D = |dz| w <= 2^30.  A quotient above 2^13 only has to
 *              remain outside the tile.  For smaller quotients, a unit in the last
 *              place is <= 2^-40 < 2^-30.
 *   crossings  In owned rows, i is in [0, 2^12] and nx <= 2^40.  The quotient is
 *              within 2^12 of zero, where a unit in the last place is
 *              <= 2^-41 < 2^-40.  The dividend is within nx 2^12 <= 2^52 of zero,
 *              so it is a double.
 * Ranges in int64: |dy (Z - az)|, |dz (ay - h)| <= 2^41; |nx (..)| <= 2^49;
 * |ny (Y - ay)|, |nz (Z - az)| <= 2^60 (docs/spec/arithmetic.md, section 10).
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "cpu/voxelize/voxelize.h"

enum { X, Y, Z };

/* Returns floor(q) for |q| <= 2^43. */
static int64_t floor_of(double q)
{
    int64_t t = (int64_t)q;
    return t - ((double)t > q);
}

static int64_t ceil_of(double q)
{
    int64_t t = (int64_t)q;
    return t + ((double)t < q);
}

static int32_t least3(int32_t a, int32_t b, int32_t c)
{
    int32_t m = a < b ? a : b;
    return m < c ? m : c;
}

static int32_t greatest3(int32_t a, int32_t b, int32_t c)
{
    int32_t m = a > b ? a : b;
    return m > c ? m : c;
}

void ost_vox_spill(ost_vox_tile *tile, uint32_t row, int32_t i, int step)
{
    const size_t stride = (size_t)tile->nx + 1;
    if (!tile->spill && !tile->no_memory) {
        tile->spill = malloc(ost_vox_rows(tile) * stride * sizeof *tile->spill);
        tile->no_memory = !tile->spill;
    }
    if (tile->no_memory)
        return;
    int32_t *steps = tile->spill + row * stride;
    if (!(tile->row_state[row] & OST_VOX_SPILLED)) {
        memset(steps, 0, stride * sizeof *steps);
        tile->row_state[row] |= OST_VOX_SPILLED;
        tile->any_unproven = true;
    }
    steps[i] += step;
}

typedef struct edge {
    int64_t c;  /* C in the tile's first slice (formula at the top of this file) */
    int64_t dc; /* difference of C between neighbouring slices */
    int64_t dz;
    double d; /* dz w */
} edge;

static edge edge_from(const int32_t *a, const int32_t *b, int64_t z, int f)
{
    const int64_t w = INT64_C(1) << f, dy = b[Y] - a[Y], dz = b[Z] - a[Z];
    const bool tie = dz < 0 || (dz == 0 && dy > 0);
    return (edge){
        .c = dy * (z - a[Z]) + dz * (a[Y] - (1 << (f - 1))) - !tie, .dc = dy * w, .dz = dz, .d = (double)(dz * w)};
}

/* Reduces the range of rows [lo, hi] to the rows on the inner side of the edge. */
static void clip(const edge *e, int64_t *lo, int64_t *hi)
{
    if (e->dz > 0) {
        int64_t q = floor_of((double)e->c / e->d);
        *hi = q < *hi ? q : *hi;
    } else if (e->dz < 0) {
        int64_t q = ceil_of((double)e->c / e->d);
        *lo = q > *lo ? q : *lo;
    } else if (e->c < 0) {
        *hi = *lo - 1;
    }
}

void ost_vox_mark_triangle(ost_vox_tile *tile, uint32_t triangle)
{
    const uint32_t *t = tile->mesh->triangles[triangle];
    const int32_t *a = tile->mesh->vertices[t[0]], *b = tile->mesh->vertices[t[1]], *c = tile->mesh->vertices[t[2]];
    const int f = tile->f;
    const int32_t h = 1 << (f - 1);

    int64_t j_first = (least3(a[Y], b[Y], c[Y]) + h - 1) >> f, j_last = (greatest3(a[Y], b[Y], c[Y]) - h) >> f;
    int64_t k_first = (least3(a[Z], b[Z], c[Z]) + h - 1) >> f, k_last = (greatest3(a[Z], b[Z], c[Z]) - h) >> f;
    j_first = j_first > tile->j0 ? j_first : tile->j0;
    k_first = k_first > tile->k0 ? k_first : tile->k0;
    j_last = j_last < tile->j1 ? j_last : tile->j1 - 1;
    k_last = k_last < tile->k1 ? k_last : tile->k1 - 1;
    if (j_first > j_last || k_first > k_last)
        return;

    int64_t u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (int64_t)b[i] - a[i];
        v[i] = (int64_t)c[i] - a[i];
    }
    int64_t nx = u[Y] * v[Z] - u[Z] * v[Y], ny = u[Z] * v[X] - u[X] * v[Z], nz = u[X] * v[Y] - u[Y] * v[X];
    if (nx == 0)
        return;
    const bool enters = nx < 0;
    if (enters) {
        const int32_t *swap = b;
        b = c;
        c = swap;
        nx = -nx;
        ny = -ny;
        nz = -nz;
    }

    const int64_t y = (j_first << f) + h, z = (k_first << f) + h;
    edge ab = edge_from(a, b, z, f), bc = edge_from(b, c, z, f), ca = edge_from(c, a, z, f);
    const int64_t home = a[X] >> f;
    const double d = (double)nx;
    const int64_t w = INT64_C(1) << f;
    int64_t m = nx * (a[X] - (home << f) - h) - ny * (y - a[Y]) - nz * (z - a[Z]);
    for (int64_t k = k_first; k <= k_last; k++) {
        int64_t lo = j_first, hi = j_last;
        clip(&ab, &lo, &hi);
        clip(&bc, &lo, &hi);
        clip(&ca, &lo, &hi);
        uint32_t row = (uint32_t)((k - tile->k0) * (tile->j1 - tile->j0) + (lo - tile->j0));
        for (int64_t j = lo; j <= hi; j++, row++) {
            const int64_t n = -((-(m - (j - j_first) * ny * w)) >> f); /* ceil */
            const int64_t i = home + ceil_of((double)n / d);
            assert((i - home) * nx >= n && (i - home - 1) * nx < n && i >= 0 && i <= tile->nx);
            if (i == tile->nx)
                ost_vox_spill(tile, row, (int32_t)i, enters ? 1 : -1);
            else
                ost_vox_mark_bit(tile, (enters ? 0 : tile->minus) + row * tile->row_bits + (uint32_t)i);
        }
        ab.c += ab.dc;
        bc.c += bc.dc;
        ca.c += ca.dc;
        m -= nz * w;
    }
}

void ost_vox_mark_scalar(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        ost_vox_mark_triangle(tile, list ? list[i] : (uint32_t)i);
}

void ost_vox_keys_scalar(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                         uint32_t *keys)
{
    const int f = plan->f;
    const int32_t h = 1 << (f - 1);
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = mesh->triangles[first + i];
        const int32_t *a = mesh->vertices[t[0]], *b = mesh->vertices[t[1]], *c = mesh->vertices[t[2]];
        const int32_t j0 = (least3(a[Y], b[Y], c[Y]) + h - 1) >> f, j1 = (greatest3(a[Y], b[Y], c[Y]) - h) >> f;
        const int32_t k0 = (least3(a[Z], b[Z], c[Z]) + h - 1) >> f, k1 = (greatest3(a[Z], b[Z], c[Z]) - h) >> f;
        if (j0 > j1 || k0 > k1)
            keys[i] = OST_VOX_KEY_NONE;
        else if (j0 >> plan->shift_y != j1 >> plan->shift_y || k0 >> plan->shift_z != k1 >> plan->shift_z)
            keys[i] = OST_VOX_KEY_MANY;
        else
            keys[i] = (uint32_t)((j0 >> plan->shift_y) + plan->tiles_y * (k0 >> plan->shift_z));
    }
}
