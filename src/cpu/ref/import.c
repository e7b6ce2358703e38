/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the samples of a CT text to the cubic grid (thesis, Algs. 2.2-2.5).
 *
 *   sample at p --RHE((p - origin) / spacing)--> voxel of the rect grid             AR-CT-4
 *
 *   offset      0        1/8        3/8   1/2 of a voxel
 *               |---------|----------|-----|
 *               accepted  counted    rejected                                       AR-CT-5
 *
 *   cubic voxel i is computed from rect voxels around t = ((2i + 1) c - s) / (2s)  AR-CUB
 *   where c is the spacing of the cubic grid and s the spacing of the rect grid
 */
#include "cpu/ref/ref.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

ost_status ost_ref_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    int64_t count = ost_dims_count(geometry->dims);
    ref_grid *grid = malloc(sizeof *grid);
    int16_t *voxels = calloc((size_t)count, sizeof *voxels);
    if (!grid || !voxels) {
        free(voxels);
        free(grid);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %d x %d x %d voxels (%lld bytes)",
                        geometry->dims.x, geometry->dims.y, geometry->dims.z, (long long)count * 2);
    }
    *grid = (ref_grid){.base = {.backend = backend, .geometry = *geometry}, .voxels = voxels};
    *out = &grid->base;
    return OST_OK;
}

void ost_ref_grid_free(ost_grid *base)
{
    ref_grid *grid = (ref_grid *)base;
    free(grid->voxels);
    free(grid->seen);
    free(grid);
}

static size_t slice_voxels(const ost_geometry *geometry)
{
    return (size_t)geometry->dims.x * (size_t)geometry->dims.y;
}

ost_status ost_ref_grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    (void)err;
    ref_grid *grid = (ref_grid *)base;
    size_t slice = slice_voxels(&base->geometry);
    memcpy(grid->voxels + slice * (size_t)z0, voxels, slice * (size_t)count * sizeof *voxels);
    return OST_OK;
}

ost_status ost_ref_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    const ref_grid *grid = (const ref_grid *)base;
    size_t slice = slice_voxels(&base->geometry);
    memcpy(voxels, grid->voxels + slice * (size_t)z0, slice * (size_t)count * sizeof *voxels);
    return OST_OK;
}

/* ------------------------------------------------- samples to rect grid */

/*
 * The position of a sample p on one axis, relative to the lattice of voxels.
 *
 * Ranges. |p|, |origin| <= 8 m = 8 * 10^12 pm < 2^43, so p - origin is within 2^44.
 * index * spacing differs from p - origin by at most half a spacing, so it is within 2^45.
 * |off| <= spacing / 2 <= 5 * 10^10 pm < 2^36, so 8 * off and 3 * spacing are within 2^39,
 * and off * 10^6 is within 2^56.
 */
typedef struct lattice {
    int64_t index;
    int64_t off;     /* |p - lattice point| */
    int64_t spacing; /* spacing of the axis; off / spacing is the distance in voxels */
} lattice;

static lattice on_lattice(ost_pm p, ost_pm origin, ost_pm spacing)
{
    int64_t index = ost_rhe_div(p - origin, spacing);
    int64_t off = p - origin - index * spacing;
    return (lattice){index, off < 0 ? -off : off, spacing};
}

static bool beyond(const lattice at[3], int eighths)
{
    return 8 * at[0].off > eighths * at[0].spacing || 8 * at[1].off > eighths * at[1].spacing ||
           8 * at[2].off > eighths * at[2].spacing;
}

static uint64_t offset_ppm(const lattice at[3])
{
    uint64_t worst = 0;
    for (int a = 0; a < 3; a++) {
        uint64_t ppm = (uint64_t)(at[a].off * 1000000 / at[a].spacing);
        worst = ppm > worst ? ppm : worst;
    }
    return worst;
}

static bool inside(const lattice at[3], ost_dims dims)
{
    return at[0].index >= 0 && at[0].index < dims.x && at[1].index >= 0 && at[1].index < dims.y && at[2].index >= 0 &&
           at[2].index < dims.z;
}

static bool readable(const ost_sample *s)
{
    return s->x >= -OST_LENGTH_MAX && s->x <= OST_LENGTH_MAX && s->y >= -OST_LENGTH_MAX && s->y <= OST_LENGTH_MAX &&
           s->z >= -OST_LENGTH_MAX && s->z <= OST_LENGTH_MAX;
}

static bool before(int64_t line, int64_t recorded)
{
    return recorded == 0 || line < recorded;
}

/* Handles a sample whose voxel already has a sample (AR-CT-6). Two samples with equal densities are never a
   conflict, regardless of `duplicates`. */
static void meet_again(int16_t *voxel, int16_t density, int64_t line, ost_duplicates duplicates,
                       ost_scatter_report *report)
{
    report->duplicates++;
    switch (duplicates) {
    case OST_DUPLICATES_ERROR:
        if (density != *voxel && before(line, report->conflict_line)) {
            report->conflict_line = line;
            report->conflict_had = *voxel;
            report->conflict_has = density;
        }
        break;
    case OST_DUPLICATES_FIRST:
        break;
    case OST_DUPLICATES_LAST:
        *voxel = density;
        break;
    case OST_DUPLICATES_MAX:
        if (density > *voxel)
            *voxel = density;
        break;
    }
}

static void scatter(ref_grid *grid, const ost_sample *sample, int64_t line, ost_duplicates duplicates,
                    ost_scatter_report *report)
{
    const ost_geometry *g = &grid->base.geometry;
    report->samples++;
    if (!readable(sample)) {
        if (before(line, report->rejected_line))
            report->rejected_line = line;
        return;
    }
    lattice at[3] = {
        on_lattice(sample->x, g->origin.x, g->spacing.x),
        on_lattice(sample->y, g->origin.y, g->spacing.y),
        on_lattice(sample->z, g->origin.z, g->spacing.z),
    };
    if (beyond(at, 1))
        report->off_lattice++;
    uint64_t ppm = offset_ppm(at);
    if (ppm > report->worst_offset_ppm ||
        (ppm > 0 && ppm == report->worst_offset_ppm && before(line, report->worst_line))) {
        report->worst_offset_ppm = ppm;
        report->worst_line = line;
    }
    if (beyond(at, 3) || !inside(at, g->dims)) {
        if (before(line, report->rejected_line))
            report->rejected_line = line;
        return;
    }
    size_t v = (size_t)(at[0].index + g->dims.x * (at[1].index + g->dims.y * at[2].index));
    uint8_t bit = (uint8_t)(1u << (v % 8));
    if (grid->seen[v / 8] & bit) {
        meet_again(&grid->voxels[v], (int16_t)sample->density, line, duplicates, report);
    } else {
        grid->seen[v / 8] |= bit;
        grid->voxels[v] = (int16_t)sample->density;
    }
}

ost_status ost_ref_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                              ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    ref_grid *grid = (ref_grid *)rect;
    if (!grid->seen) {
        size_t bytes = (size_t)((ost_dims_count(rect->geometry.dims) + 7) / 8);
        grid->seen = calloc(bytes, 1);
        if (!grid->seen)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the set of voxels that have a value (%zu bytes)",
                            bytes);
    }
    for (size_t i = 0; i < count; i++) {
        assert(samples[i].density >= INT16_MIN && samples[i].density <= INT16_MAX);
        scatter(grid, &samples[i], first_line + samples[i].line, duplicates, report);
    }
    return OST_OK;
}

/* --------------------------------------------------- rect grid to cubic */

enum { WEIGHT_BITS = 15 };

/*
 * The rect voxels on one axis from which a cubic voxel is computed, and their weights. Voxel `index` has the
 * weight 2^15 - weight. Voxel index + 1 has the weight `weight` and is read only if `weight` is above 0.
 */
typedef struct tap {
    int64_t index;
    int64_t weight; /* 0 to 2^15 */
} tap;

/*
 * Returns the tap of cubic voxel i by the `linear` rule, for the spacings c = cubic and s = rect.
 * AR-CUB-2: t = n / d, n = (2i + 1) c - s, d = 2s, clamped to 0 <= t <= last.
 * (2i + 1) c < 2^15 * 2^37, d < 2^38, and the remainder n - index d < d, so
 * 2^15 * remainder < 2^53. If the weight is not 0, then t < last, so index + 1 <= last.
 */
static tap linear_tap(int64_t i, ost_pm cubic, ost_pm rect, int64_t last)
{
    const int64_t n = (2 * i + 1) * cubic - rect, d = 2 * rect;
    if (n <= 0)
        return (tap){0, 0};
    const int64_t index = ost_floor_div(n, d);
    if (index >= last)
        return (tap){last, 0};
    return (tap){index, ost_rhe_div((n - index * d) << WEIGHT_BITS, d)};
}

/*
 * Returns the tap of cubic voxel i by the given resampling rule. i * cubic < 2^14 * 2^37.
 * AR-CUB-4: floor(i * cubic / rect) < dim, because i < ceil(dim * rect / cubic).
 */
static tap tap_at(int64_t i, ost_pm cubic, ost_pm rect, int32_t dim, ost_resample rule)
{
    const int64_t last = dim - 1;
    if (rule == OST_RESAMPLE_LINEAR)
        return linear_tap(i, cubic, rect, last);
    if (rule == OST_RESAMPLE_THESIS)
        return (tap){ost_floor_div(i * cubic, rect), 0};
    const int64_t nearest = ost_floor_div((2 * i + 1) * cubic, 2 * rect);
    return (tap){nearest < last ? nearest : last, 0};
}

/*
 * Returns the weighted mean of eight voxels, rounded by RHE. The products of weights sum
 * to 2^45, so |sum| <= 2^45 * 2^15 = 2^60. The mean lies between the least and the greatest
 * of the eight voxels. These are integers, so the rounded mean lies between them too.
 */
static int16_t weighted(const ref_grid *grid, tap x, tap y, tap z)
{
    const ost_dims dims = grid->base.geometry.dims;
    const int64_t one = INT64_C(1) << WEIGHT_BITS;
    int64_t sum = 0;
    for (int dz = 0; dz < 2; dz++) {
        for (int dy = 0; dy < 2; dy++) {
            for (int dx = 0; dx < 2; dx++) {
                const int64_t weight = (dx ? x.weight : one - x.weight) * (dy ? y.weight : one - y.weight) *
                                       (dz ? z.weight : one - z.weight);
                if (weight > 0)
                    sum += weight * grid->voxels[x.index + dx + dims.x * (y.index + dy + dims.y * (z.index + dz))];
            }
        }
    }
    return (int16_t)ost_rhe_div(sum, one * one * one);
}

ost_status ost_ref_rect_to_cubic(const ost_grid *rect_base, const ost_geometry *geometry, ost_resample rule,
                                 ost_grid **out, ost_error *err)
{
    const ref_grid *rect = (const ref_grid *)rect_base;
    const ost_geometry *r = &rect_base->geometry;
    ost_status status = ost_ref_grid_create(rect_base->backend, geometry, out, err);
    if (status != OST_OK)
        return status;
    int16_t *to = ((ref_grid *)*out)->voxels;
    for (int32_t k = 0; k < geometry->dims.z; k++) {
        const tap z = tap_at(k, geometry->spacing.z, r->spacing.z, r->dims.z, rule);
        for (int32_t j = 0; j < geometry->dims.y; j++) {
            const tap y = tap_at(j, geometry->spacing.y, r->spacing.y, r->dims.y, rule);
            for (int32_t i = 0; i < geometry->dims.x; i++) {
                const tap x = tap_at(i, geometry->spacing.x, r->spacing.x, r->dims.x, rule);
                *to++ = weighted(rect, x, y, z);
            }
        }
    }
    return OST_OK;
}
