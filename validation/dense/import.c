/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the stages from samples to the rect grid and from the rect grid to the cubic grid (AR-CT-4 to 6,
   AR-CUB). */
#include "validation/dense/parts.h"

#include <stdlib.h>
#include <string.h>

static size_t count_of(const ost_grid *grid)
{
    return (size_t)ost_dims_count(grid->geometry.dims);
}

ost_status dense_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    dense_grid *grid = calloc(1, sizeof *grid);
    if (!grid)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid");
    grid->base = (ost_grid){.backend = backend, .geometry = *geometry};
    grid->made.voxels = calloc(count_of(&grid->base), sizeof *grid->made.voxels);
    if (!grid->made.voxels) {
        free(grid);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %d x %d x %d voxels", geometry->dims.x,
                        geometry->dims.y, geometry->dims.z);
    }
    *out = &grid->base;
    return OST_OK;
}

void dense_grid_free(ost_grid *base)
{
    dense_grid *grid = (dense_grid *)base;
    dense_grid_finish(grid);
    free(grid->made.voxels);
    free(grid->made.seen);
    free(grid->right.voxels);
    free(grid->right.seen);
    free(grid);
}

static size_t slice_of(const ost_grid *grid)
{
    return (size_t)grid->geometry.dims.x * (size_t)grid->geometry.dims.y;
}

ost_status dense_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    (void)err;
    const size_t slice = slice_of(grid);
    memcpy(((dense_grid *)grid)->made.voxels + (size_t)z0 * slice, voxels, (size_t)count * slice * sizeof *voxels);
    return OST_OK;
}

ost_status dense_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    const size_t slice = slice_of(grid);
    memcpy(voxels, ((const dense_grid *)grid)->made.voxels + (size_t)z0 * slice,
           (size_t)count * slice * sizeof *voxels);
    return OST_OK;
}

/* --------------------------------------------------------- the rect grid */

/* The parameters that all samples of a batch share. */
typedef struct batch {
    deviant *m;
    const ost_geometry *g;
    ost_duplicates duplicates;
    uint64_t first_item; /* number of the batch's first sample, counted over all samples of the grid */
    bool short_rows, last_layer_lost;
} batch;

static bool lower(int64_t line, int64_t known)
{
    return known == 0 || line < known;
}

/* Returns the index at which a sample is stored, computed by AR-CT-4 or with a deliberate mistake; -1 if the sample
   is not stored. */
static int64_t where(const batch *b, const ost_sample *s, uint64_t item, const int64_t index[3])
{
    const ost_dims d = b->g->dims;
    const int32_t right[3] = {(int32_t)index[0], (int32_t)index[1], (int32_t)index[2]};
    const int64_t at = dense_at(d, index[0], index[1], index[2]);
    int64_t other = at;
    bool fused;
    if (deviates(b->m, DEVIATION_TRUNCATED_INDEX, item)) {
        const ost_pm p[3] = {s->x, s->y, s->z}, o[3] = {b->g->origin.x, b->g->origin.y, b->g->origin.z},
                     size[3] = {b->g->spacing.x, b->g->spacing.y, b->g->spacing.z};
        int64_t cut[3];
        for (int a = 0; a < 3; a++) {
            const float position = (float)((double)p[a] / 1e9), minimum = (float)((double)o[a] / 1e9);
            cut[a] = (int64_t)((position - minimum) / (float)((double)size[a] / 1e9));
        }
        other = cut[0] < d.x && cut[1] < d.y && cut[2] < d.z ? dense_at(d, cut[0], cut[1], cut[2]) : -1;
    }
    if (b->short_rows)
        other = index[0] + (d.x - 1) * (index[1] + (int64_t)d.y * index[2]);
    if (b->last_layer_lost && index[2] == d.z - 1)
        other = -1;
    if (deviant_thesis(b->m, &fused)) {
        int64_t cut[3];
        other = dense_thesis_rect(b->g, s, cut) ? dense_at(d, cut[0], cut[1], cut[2]) : -1;
    }
    if (other != at)
        deviant_acted(b->m, item, right);
    return other;
}

static void scatter(const batch *b, dense_scatter *to, const ost_sample *s, uint64_t number, int64_t line,
                    ost_scatter_report *report)
{
    const uint64_t item = b->first_item + number;
    const ost_pm p[3] = {s->x, s->y, s->z}, o[3] = {b->g->origin.x, b->g->origin.y, b->g->origin.z},
                 size[3] = {b->g->spacing.x, b->g->spacing.y, b->g->spacing.z};
    const int32_t dims[3] = {b->g->dims.x, b->g->dims.y, b->g->dims.z};
    bool off = false, rejected = false;
    uint64_t worst = 0;
    int64_t index[3];
    report->samples++;
    for (int a = 0; a < 3; a++)
        /* the coordinate is beyond the maximum length (AR-LEN-1) */
        if (p[a] > OST_LENGTH_MAX || p[a] < -OST_LENGTH_MAX) {
            if (lower(line, report->rejected_line))
                report->rejected_line = line;
            return;
        }
    for (int a = 0; a < 3; a++) {
        index[a] = (int64_t)dense_nearest(p[a] - o[a], size[a]);
        int64_t offset = p[a] - o[a] - index[a] * size[a];
        if (offset < 0)
            offset = -offset;
        if (8 * offset > size[a])
            off = true;
        if (8 * offset > 3 * size[a] || index[a] < 0 || index[a] >= dims[a])
            rejected = true;
        const uint64_t millionths = (uint64_t)(1000000 * offset / size[a]);
        if (millionths > worst)
            worst = millionths;
    }
    if (off)
        report->off_lattice++;
    if (worst > 0 &&
        (worst > report->worst_offset_ppm || (worst == report->worst_offset_ppm && lower(line, report->worst_line)))) {
        report->worst_offset_ppm = worst;
        report->worst_line = line;
    }
    if (rejected) {
        if (lower(line, report->rejected_line))
            report->rejected_line = line;
        return;
    }
    const int64_t at = where(b, s, item, index);
    if (at < 0)
        return;
    int16_t density = (int16_t)s->density;
    if (deviates(b->m, DEVIATION_SATURATED_SHORT, item)) {
        const int16_t wide = density;
        density = density < -1024 ? -1024 : density > 3071 ? 3071 : density;
        if (density != wide)
            deviant_acted(b->m, item, (const int32_t[3]){(int32_t)index[0], (int32_t)index[1], (int32_t)index[2]});
    }
    bool fused;
    if (!to->seen[at] || deviant_thesis(b->m, &fused)) {
        if (to->seen[at])
            report->duplicates++;
        to->seen[at] = 1;
        to->voxels[at] = density;
        return;
    }
    report->duplicates++;
    const int16_t had = to->voxels[at];
    int16_t stays = had;
    const bool conflict = b->duplicates == OST_DUPLICATES_ERROR && density != had;
    if (b->duplicates == OST_DUPLICATES_LAST || (b->duplicates == OST_DUPLICATES_MAX && density > had))
        stays = density;
    if (density != had && deviates(b->m, DEVIATION_LOST_DUPLICATE_RULE, item)) {
        to->voxels[at] = stays == density ? had : density;
        deviant_acted(b->m, item, (const int32_t[3]){(int32_t)index[0], (int32_t)index[1], (int32_t)index[2]});
        return;
    }
    if (conflict && lower(line, report->conflict_line)) {
        report->conflict_line = line;
        report->conflict_had = had;
        report->conflict_has = density;
    }
    to->voxels[at] = stays;
}

static void run_batch(deviant *m, const dense_grid *grid, dense_scatter *to, const ost_sample *samples, size_t count,
                      int64_t first_line, ost_duplicates duplicates, ost_scatter_report *report)
{
    const uint64_t number = grid->batches;
    const ost_dims d = grid->base.geometry.dims;
    batch b = {.m = m, .g = &grid->base.geometry, .duplicates = duplicates, .first_item = grid->samples};
    b.short_rows = d.x > 1 && deviates(m, DEVIATION_OFF_BY_ONE_DIMS, number);
    b.last_layer_lost = deviates(m, DEVIATION_LAST_LAYER_LOST, number);
    if (count % 64 != 0 && deviates(m, DEVIATION_DROPPED_LAST_ITEMS, number)) {
        count -= count % 64;
        deviant_acted(m, number, NULL);
    }
    if (first_line != 0 && deviates(m, DEVIATION_RELATIVE_LINE, number)) {
        first_line = 0;
        deviant_acted(m, number, NULL);
    }
    if (report->samples > 0 && deviates(m, DEVIATION_REPORT_OVERWRITTEN, number)) {
        *report = (ost_scatter_report){0};
        deviant_acted(m, number, NULL);
    }
    for (size_t i = 0; i < count; i++)
        scatter(&b, to, &samples[i], i, first_line + samples[i].line, report);
}

static void fill_with_garbage(deviant *m, const dense_grid *grid)
{
    const ost_dims d = grid->base.geometry.dims;
    int64_t at = 0;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++, at++)
                if (deviates(m, DEVIATION_GARBAGE_IN_VOID, (uint64_t)at)) {
                    grid->made.voxels[at] = (int16_t)(deviant_draw(m, (uint64_t)at) >> 32 | 1);
                    deviant_acted(m, (uint64_t)at, (const int32_t[3]){i, j, k});
                }
}

/* Allocates the arrays of a grid, before its first batch of samples. */
static ost_status prepare(dense_grid *grid, ost_error *err)
{
    deviant *m = dense_of(grid->base.backend)->deviant;
    const size_t count = count_of(&grid->base);
    grid->made.seen = calloc(count, 1);
    if (!grid->made.seen)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for which voxels have a sample");
    if (!deviant_in(m, DEVIATION_RECT))
        return OST_OK;
    grid->right.seen = calloc(count, 1);
    grid->right.voxels = malloc(count * sizeof *grid->right.voxels);
    if (!grid->right.seen || !grid->right.voxels) {
        free(grid->made.seen);
        free(grid->right.seen);
        free(grid->right.voxels);
        grid->made.seen = grid->right.seen = NULL;
        grid->right.voxels = NULL;
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the grid without the deviation");
    }
    memcpy(grid->right.voxels, grid->made.voxels, count * sizeof *grid->right.voxels);
    deviant_begin(m, DEVIATION_RECT, grid->base.geometry.dims, 0);
    grid->call = m->call;
    fill_with_garbage(m, grid);
    return OST_OK;
}

ost_status dense_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                            ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    dense_grid *grid = (dense_grid *)rect;
    dense *d = dense_of(rect->backend);
    if (!grid->made.seen) {
        if (d->unsettled)
            dense_grid_finish(d->unsettled);
        const ost_status status = prepare(grid, err);
        if (status != OST_OK)
            return status;
        grid->right.report = *report;
    }
    const bool twice = deviant_in(d->deviant, DEVIATION_RECT);
    if (twice) {
        deviant_return(d->deviant, DEVIATION_RECT, grid->call, rect->geometry.dims, 0);
        run_batch(NULL, grid, &grid->right, samples, count, first_line, duplicates, &grid->right.report);
    }
    run_batch(d->deviant, grid, &grid->made, samples, count, first_line, duplicates, report);
    grid->made.report = *report;
    grid->samples += count;
    grid->batches++;
    grid->scattered = true;
    d->unsettled = twice ? grid : NULL;
    return OST_OK;
}

/* Records each voxel in which the grid with the mistake differs from the correct grid. */
static void note_changes(deviant *m, ost_dims d, const int16_t *made, const int16_t *right)
{
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++)
                if (*made++ != *right++)
                    deviant_changed_voxel(m, (const int32_t[3]){i, j, k});
}

static bool same_report(const ost_scatter_report *a, const ost_scatter_report *b)
{
    return a->samples == b->samples && a->duplicates == b->duplicates && a->off_lattice == b->off_lattice &&
           a->worst_offset_ppm == b->worst_offset_ppm && a->worst_line == b->worst_line &&
           a->rejected_line == b->rejected_line && a->conflict_line == b->conflict_line &&
           a->conflict_had == b->conflict_had && a->conflict_has == b->conflict_has;
}

void dense_grid_finish(dense_grid *grid)
{
    dense *d = dense_of(grid->base.backend);
    if (d->unsettled != grid)
        return;
    d->unsettled = NULL;
    deviant_return(d->deviant, DEVIATION_RECT, grid->call, grid->base.geometry.dims, 0);
    note_changes(d->deviant, grid->base.geometry.dims, grid->made.voxels, grid->right.voxels);
    if (!same_report(&grid->made.report, &grid->right.report))
        deviant_changed_report(d->deviant, -1);
}

/* -------------------------------------------------------- the cubic grid */

/* The source of a cubic voxel along one axis: a mean, in which rect voxel `index` has the weight ONE - weight,
   and the next rect voxel has the weight `weight`. If `weight` is 0, the next voxel is not read. */
typedef struct source {
    int64_t index;
    int32_t weight;
} source;

enum { ONE = 1 << 15 };

/* Computes the source of cubic voxel i, and its weight (AR-CUB-2 to 4). */
static source source_of(int32_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    if (rule == OST_RESAMPLE_THESIS)
        return (source){(int64_t)dense_floor((int128)i * cubic, rect), 0};
    int128 t = (2 * (int128)i + 1) * cubic; /* numerator of the source position; the denominator is 2 * rect */
    const int128 unit = 2 * (int128)rect;
    if (rule == OST_RESAMPLE_NEAREST)
        return (source){(int64_t)(t / unit > n - 1 ? n - 1 : t / unit), 0};
    t -= rect;
    if (t < 0)
        t = 0;
    if (t > (n - 1) * unit)
        t = (n - 1) * unit;
    return (source){(int64_t)(t / unit), (int32_t)dense_nearest(t % unit * ONE, unit)};
}

/* Returns true if the centre of the cubic voxel lies exactly on the centre of a source voxel other than the first
   source voxel. For the `thesis` rule, the lower borders of the voxels are compared instead of the centres. */
static bool on_multiple(int32_t i, ost_pm cubic, ost_pm rect, source right, ost_resample rule)
{
    const int128 t = rule == OST_RESAMPLE_LINEAR ? (2 * (int128)i + 1) * cubic - rect
                                                     : 2 * (int128)i * cubic;
    return right.index > 0 && rule != OST_RESAMPLE_NEAREST && (int128)right.index * 2 * rect == t;
}

static source float_source(int32_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    const float c = (float)((double)cubic / 1e9), s = (float)((double)rect / 1e9),
                first = rule == OST_RESAMPLE_THESIS ? 0 : 0.5f * c;
    float t = (first + (float)i * c) / s - (rule == OST_RESAMPLE_LINEAR ? 0.5f : 0);
    t = t < 0 ? 0 : t > (float)(n - 1) ? (float)(n - 1) : t;
    const int64_t index = (int64_t)t;
    return (source){index, rule == OST_RESAMPLE_LINEAR ? (int32_t)((t - (float)index) * ONE) : 0};
}

/* Returns the source of cubic voxel i, computed by AR-CUB or with a deliberate mistake. Axis 2 is z. */
static source chosen(deviant *m, int axis, int32_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule,
                     bool other_rule)
{
    const uint64_t item = (uint64_t)axis << 32 | (uint64_t)i;
    const source right = source_of(i, cubic, rect, n, rule);
    source made = right;
    bool fused;
    if (other_rule)
        made = source_of(i, cubic, rect, n, rule == OST_RESAMPLE_NEAREST ? OST_RESAMPLE_THESIS : OST_RESAMPLE_NEAREST);
    if (deviates(m, DEVIATION_FLOAT_LAYER, item))
        made = float_source(i, cubic, rect, n, rule);
    if (right.weight > 0 && deviates(m, DEVIATION_TEXTURE_WEIGHTS, item))
        made.weight = (right.weight + ONE / 512) / (ONE / 256) * (ONE / 256);
    if (axis == 2 && right.index > 0 && deviates(m, DEVIATION_LAYER_OFF_BY_ONE, item))
        made.index = right.index - 1;
    if (on_multiple(i, cubic, rect, right, rule) && deviates(m, DEVIATION_MULTIPLE_OFF_BY_ONE, item))
        made.index = right.index - 1;
    if (deviant_thesis(m, &fused))
        made = (source){axis == 2 ? dense_thesis_layer(i, cubic, rect, fused) : i, 0};
    if (made.index > n - 1 || (made.index == n - 1 && made.weight > 0))
        made = (source){n - 1, 0};
    if (made.index != right.index || made.weight != right.weight)
        deviant_acted(m, item, NULL);
    return made;
}

/* Returns the density that is read for voxel (x, y, z). If `swapped` or `padded` is true, the density is read from the
   position that the voxel would have in a wrong memory layout. */
static int16_t read_source(const dense_grid *rect, int64_t x, int64_t y, int64_t z, bool swapped, bool padded)
{
    const ost_dims d = rect->base.geometry.dims;
    int64_t at = dense_at(d, x, y, z);
    if (swapped)
        at = y + d.y * (x + (int64_t)d.x * z);
    if (padded)
        at = x + (d.x + 31) / 32 * 32 * (y + (int64_t)d.y * z);
    return at < ost_dims_count(d) ? rect->made.voxels[at] : 0;
}

/* Returns a * (ONE - w) + b * w. The scale of the result is 2^15 times the scale of a and b. Three applications, along
   x, then y, then z, give the weighted sum of all eight values. */
static int64_t mixed(int64_t a, int64_t b, int32_t w)
{
    return a * (ONE - w) + b * w;
}

static int16_t mean_of(const dense_grid *rect, const source s[3], bool swapped, bool padded, bool each)
{
    int64_t planes[2] = {0, 0};
    for (int k = 0; k < 2 - (s[2].weight == 0); k++) {
        int64_t rows[2] = {0, 0};
        for (int j = 0; j < 2 - (s[1].weight == 0); j++) {
            const int64_t y = s[1].index + j, z = s[2].index + k;
            const int64_t lower = read_source(rect, s[0].index, y, z, swapped, padded);
            const int64_t upper = s[0].weight == 0 ? 0 : read_source(rect, s[0].index + 1, y, z, swapped, padded);
            rows[j] = mixed(lower, upper, s[0].weight);
            if (each)
                rows[j] = (int64_t)dense_nearest(rows[j], ONE);
        }
        planes[k] = mixed(rows[0], rows[1], s[1].weight);
        if (each)
            planes[k] = (int64_t)dense_nearest(planes[k], ONE);
    }
    const int64_t sum = mixed(planes[0], planes[1], s[2].weight);
    return (int16_t)dense_nearest(sum, each ? (int128)ONE : (int128)ONE * ONE * ONE);
}

static void resample(deviant *m, const dense_grid *rect, const ost_geometry *c, ost_resample rule, int16_t *to)
{
    const ost_geometry *r = &rect->base.geometry;
    const bool other_rule = deviates(m, DEVIATION_OTHER_RULE, 0), swapped = deviates(m, DEVIATION_SWAPPED_AXIS, 0),
               padded = r->dims.x % 32 != 0 && deviates(m, DEVIATION_PADDED_PITCH, 0),
               each = rule == OST_RESAMPLE_LINEAR && deviates(m, DEVIATION_ROUNDED_EACH, 0);
    if (swapped || padded || each)
        deviant_acted(m, 0, NULL);
    for (int32_t k = 0; k < c->dims.z; k++) {
        const source z = chosen(m, 2, k, c->spacing.z, r->spacing.z, r->dims.z, rule, other_rule);
        for (int32_t j = 0; j < c->dims.y; j++) {
            const source y = chosen(m, 1, j, c->spacing.y, r->spacing.y, r->dims.y, rule, other_rule);
            for (int32_t i = 0; i < c->dims.x; i++) {
                const source x = chosen(m, 0, i, c->spacing.x, r->spacing.x, r->dims.x, rule, other_rule);
                *to++ = mean_of(rect, (source[3]){x, y, z}, swapped, padded, each);
            }
        }
    }
}

ost_status dense_rect_to_cubic(const ost_grid *base, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                               ost_error *err)
{
    const dense_grid *rect = (const dense_grid *)base;
    dense *d = dense_of(base->backend);
    ost_grid *right = NULL;
    if (d->unsettled)
        dense_grid_finish(d->unsettled);
    ost_status status = dense_grid_create(base->backend, geometry, out, err);
    if (status == OST_OK && deviant_in(d->deviant, DEVIATION_CUBIC))
        status = dense_grid_create(base->backend, geometry, &right, err);
    if (status != OST_OK) {
        if (*out)
            dense_grid_free(*out);
        *out = NULL;
        return status;
    }
    deviant_begin(d->deviant, DEVIATION_CUBIC, geometry->dims, 0);
    resample(d->deviant, rect, geometry, rule, ((dense_grid *)*out)->made.voxels);
    if (right) {
        resample(NULL, rect, geometry, rule, ((dense_grid *)right)->made.voxels);
        note_changes(d->deviant, geometry->dims, ((dense_grid *)*out)->made.voxels, ((dense_grid *)right)->made.voxels);
        dense_grid_free(right);
    }
    return OST_OK;
}
