/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/resample.h"

#include "core/conditions.h"
#include "core/integer.h"

enum { GROWTH_FREE = 1 << 26, GROWTH_MAX = 64 };

/* Returns floor(sqrt(n)) for 0 <= n < 2^76, computed bit by bit. */
static int64_t integer_root(ost_i128 n)
{
    int64_t root = 0;
    for (int bit = 38; bit >= 0; bit--) {
        int64_t trial = root | INT64_C(1) << bit;
        if ((ost_i128)trial * trial <= n)
            root = trial;
    }
    return root;
}

ost_status ost_resample_geometry(const ost_affine *affine, const int32_t sizes[3], const ost_placement *placement,
                                 ost_geometry *out, ost_error *err)
{
    int64_t dims[3];
    ost_pm spacing[3], least[3];
    for (int a = 0; a < 3; a++) {
        ost_i128 squares = 0; /* components are below 2^37 */
        for (int w = 0; w < 3; w++)
            squares += (ost_i128)affine->column[a][w] * affine->column[a][w];
        spacing[placement->to[a]] = integer_root(squares);
    }
    for (int w = 0; w < 3; w++) {
        ost_pm extent = 0;
        least[w] = affine->origin[w];
        for (int a = 0; a < 3; a++) {
            ost_pm span = affine->column[a][w] * (sizes[a] - 1);
            extent += span < 0 ? -span : span;
            least[w] += span < 0 ? span : 0;
        }
        dims[w] = ost_ceil_div(extent, spacing[w]) + 1;
        if (dims[w] > OST_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE,
                            "resampled, it would have %lld voxels along an axis; expected at most %d",
                            (long long)dims[w], OST_DIM_MAX);
    }
    *out = (ost_geometry){
        .dims = {(int32_t)dims[0], (int32_t)dims[1], (int32_t)dims[2]},
        .spacing = {spacing[0], spacing[1], spacing[2]},
        .origin = {least[0], least[1], least[2]},
    };
    ost_status status = ost_geometry_check(out, "the resampled volume", err);
    /* The bounding box of a long, thin, diagonal grid is huge. The limit prevents a small file from causing hours of
     * work. */
    int64_t had = (int64_t)sizes[0] * sizes[1] * sizes[2], has = ost_dims_count(out->dims);
    if (status == OST_OK && has > GROWTH_FREE && has / GROWTH_MAX > had)
        return ost_fail(err, OST_ERR_RANGE,
                        "resampled, it would grow from %lld to %lld voxels; expected at most %d times",
                        (long long)had, (long long)has, GROWTH_MAX);
    return status;
}

/*
 * Ranges: columns are below 2^37, so a cofactor is below 2^75 and the determinant is below 2^114. p - origin is below
 * 2^44 (16 m) on each axis, so a numerator is below 3 * 2^119 < 2^121.
 */
void ost_resample_nearest(const ost_affine *affine, const int32_t sizes[3], const int16_t *file, ost_volume *out)
{
    ost_i128 cofactor[3][3]; /* indexed by [file axis][LPS axis] */
    for (int a = 0; a < 3; a++) {
        const ost_pm *u = affine->column[(a + 1) % 3], *v = affine->column[(a + 2) % 3];
        for (int w = 0; w < 3; w++) {
            int w1 = (w + 1) % 3, w2 = (w + 2) % 3;
            cofactor[a][w] = (ost_i128)u[w1] * v[w2] - (ost_i128)u[w2] * v[w1];
        }
    }
    ost_i128 det = 0;
    for (int w = 0; w < 3; w++)
        det += cofactor[0][w] * affine->column[0][w];
    int sign = det < 0 ? -1 : 1;
    det *= sign;

    const ost_geometry *g = &out->geometry;
    int16_t *to = out->voxels;
    for (int32_t z = 0; z < g->dims.z; z++) {
        for (int32_t y = 0; y < g->dims.y; y++) {
            for (int32_t x = 0; x < g->dims.x; x++, to++) {
                const ost_pm p[3] = {g->origin.x - affine->origin[0] + x * g->spacing.x,
                                     g->origin.y - affine->origin[1] + y * g->spacing.y,
                                     g->origin.z - affine->origin[2] + z * g->spacing.z};
                int64_t index[3];
                bool inside = true;
                for (int a = 0; a < 3 && inside; a++) {
                    ost_i128 n = sign * (cofactor[a][0] * p[0] + cofactor[a][1] * p[1] + cofactor[a][2] * p[2]);
                    /* This check avoids most divisions outside the file; the quotient then fits in 64 bits. */
                    inside = 2 * n >= -det && n <= det * sizes[a];
                    if (inside) {
                        index[a] = (int64_t)ost_rhe_div128(n, det);
                        inside = index[a] >= 0 && index[a] < sizes[a];
                    }
                }
                if (inside)
                    *to = file[index[0] + sizes[0] * (index[1] + sizes[1] * index[2])];
            }
        }
    }
}
