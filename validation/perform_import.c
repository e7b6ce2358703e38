/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the import of a case: samples or slices -> rect grid -> cubic grid -> chunks. */
#include "validation/perform_parts.h"

#include <stdlib.h>

#include "validation/resample.h"

enum { RESAMPLED_VOXELS = 1 << 19 };

static ost_status record_grid(performer *p, const ost_grid *grid, ost_error *err)
{
    const ost_dims dims = ost_grid_geometry(grid)->dims;
    const int32_t lo[3] = {0, 0, 0};
    int16_t *voxels = trace_block(p->w, lo, dims, 2);
    /* if memory is exhausted, `voxels` is NULL, and trace_end returns the error */
    return voxels ? ost_grid_download(grid, 0, dims.z, voxels, err) : OST_OK;
}

/* Uploads a CT as slices, s->slices of them per call. The CT must have one sample per voxel, on the lattice. */
static ost_status upload_ct(performer *p, ost_grid *rect, ost_error *err)
{
    const scene *s = p->s;
    const ost_geometry *g = &s->rect;
    const size_t slice = (size_t)g->dims.x * (size_t)g->dims.y;
    int16_t *voxels = calloc(slice * (size_t)g->dims.z, sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a CT of %d slices", (int)g->dims.z);
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        voxels[(size_t)((one->x - g->origin.x) / g->spacing.x) +
               (size_t)g->dims.x * (size_t)((one->y - g->origin.y) / g->spacing.y) +
               slice * (size_t)((one->z - g->origin.z) / g->spacing.z)] = (int16_t)one->density;
    }
    ost_status status = OST_OK;
    for (int32_t z = 0; z < g->dims.z && status == OST_OK; z += s->slices) {
        const int32_t count = g->dims.z - z < s->slices ? g->dims.z - z : s->slices;
        status = ost_grid_upload(rect, z, count, voxels + slice * (size_t)z, err);
    }
    free(voxels);
    return status;
}

/* Writes a record that contains the geometry and the voxels of a cubic grid. */
static ost_status record_cubic(performer *p, trace_stage stage, const ost_grid *grid, ost_error *err)
{
    const ost_geometry *g = ost_grid_geometry(grid);
    const int64_t words[] = {g->dims.x, g->dims.y, g->dims.z, g->spacing.x, g->spacing.y, g->spacing.z};
    trace_begin(p->w, stage, p->case_index, 0);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        trace_word(p->w, (uint64_t)words[i]);
    const ost_status status = record_grid(p, grid, err), written = perform_end_record(p, stage, 0, err);
    return status != OST_OK ? status : written;
}

/* Returns true if a sample was rejected or conflicts with another sample. In this case, the import ends. */
static bool refused(const ost_scatter_report *r)
{
    return r->rejected_line != 0 || r->conflict_line != 0;
}

static ost_status run_rect(performer *p, ost_grid **out, ost_error *err)
{
    const scene *s = p->s;
    ost_scatter_report r = {0};
    ost_status status = ost_grid_create(p->backend, &s->rect, out, err);
    if (s->slices && status == OST_OK)
        status = upload_ct(p, *out, err);
    for (size_t at = s->slices ? s->sample_count : 0; at < s->sample_count && status == OST_OK; at += s->batch) {
        const size_t n = s->sample_count - at < s->batch ? s->sample_count - at : s->batch;
        status = ost_ct_to_rect(*out, s->samples + at, n, (int64_t)at + 1, s->duplicates, &r, err);
    }
    if (status != OST_OK)
        return status;
    const int64_t words[] = {(int64_t)r.samples,     (int64_t)r.duplicates,
                             (int64_t)r.off_lattice, (int64_t)r.worst_offset_ppm,
                             r.worst_line,           r.rejected_line,
                             r.conflict_line,        r.conflict_had,
                             r.conflict_has};
    trace_begin(p->w, TRACE_RECT, p->case_index, 0);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        trace_word(p->w, (uint64_t)words[i]);
    if (refused(&r))
        p->refused = true;
    else
        status = record_grid(p, *out, err);
    ost_status written = perform_end_record(p, TRACE_RECT, 0, err);
    return status != OST_OK ? status : written;
}

/* Writes to the rect grid. The cubic grid made from it must not change. Writes no record. */
static ost_status add_a_sample(performer *p, ost_grid *rect, ost_error *err)
{
    const scene *s = p->s;
    ost_sample one = s->samples[0];
    ost_scatter_report ignored = {0};
    if (s->slices || p->watch)
        return OST_OK;
    one.density = one.density > 0 ? -1000 : 32767;
    return ost_ct_to_rect(rect, &one, 1, 1, OST_DUPLICATES_LAST, &ignored, err);
}

/* Returns true if the bone is made before the cubic grid is downloaded. In this case, the backend may still store the
   grid as a list of slices. */
static bool before_the_download(const performer *p)
{
    return !p->given && !p->watch;
}

static ost_status make_bone(performer *p, const ost_grid *cubic, ost_error *err)
{
    return ost_cubic_to_chunks(cubic, p->s->chunk_size, p->s->threshold, &p->bone, err);
}

/*
 * Returns true if the cubic grid is resampled a second time, to 7/5 of its voxel size. This is not done for a large
 * grid, to save time, nor for a grid whose result might exceed the range of lengths (AR-LEN-1).
 */
static bool is_resampled_again(const performer *p, const ost_grid *cubic)
{
    const ost_geometry *g = ost_grid_geometry(cubic);
    const ost_pm lo[] = {g->origin.x, g->origin.y, g->origin.z};
    const int32_t dims[] = {g->dims.x, g->dims.y, g->dims.z};
    bool is = !p->watch && ost_dims_count(g->dims) <= RESAMPLED_VOXELS && g->spacing.x <= OST_SPACING_MAX / 2;
    for (int a = 0; a < 3; a++)
        is = is && lo[a] > -OST_LENGTH_MAX / 2 && lo[a] + (dims[a] + 2) * g->spacing.x < OST_LENGTH_MAX / 2;
    return is;
}

/* Resamples the cubic grid by the case's rule. Leaves *out unchanged if the case does not resample the grid a second
   time. */
static ost_status make_again(const performer *p, const ost_grid *cubic, ost_grid **out, ost_error *err)
{
    if (!is_resampled_again(p, cubic))
        return OST_OK;
    return ost_rect_to_cubic(cubic, resample_again(p->s->cubic), p->s->resample, out, err);
}

/* Makes and records the cubic grid, and resamples it to *again before its download. Until then, a backend may store
   a grid as a list of slices, so that both grids may be such lists. */
static ost_status run_cubic(performer *p, ost_grid *rect, ost_grid **out, ost_grid **again, ost_error *err)
{
    ost_status status = ost_rect_to_cubic(rect, p->s->cubic, p->s->resample, out, err);
    if (status == OST_OK)
        status = add_a_sample(p, rect, err);
    if (status != OST_OK)
        return status;
    ost_status before = before_the_download(p) ? make_bone(p, *out, err) : OST_OK;
    if (before_the_download(p) && before == OST_OK)
        before = make_again(p, *out, again, err);
    ost_error ignored = {0};
    status = record_cubic(p, TRACE_CUBIC, *out, before == OST_OK ? err : &ignored);
    return before != OST_OK ? before : status;
}

/*
 * Writes an empty record for a stage at which the case has no grid. All backends, including the reference, write
 * this record, and it is compared. If p->watch is set, no grid is made even for a case that has one. The record is
 * then a stand-in (TRACE_STAND_IN), which is not compared.
 */
static ost_status record_no_grid(performer *p, trace_stage stage, ost_error *err)
{
    if (p->watch)
        return perform_record_nothing(p, stage, 0, err);
    trace_begin(p->w, stage, p->case_index, 0);
    return perform_end_record(p, stage, 0, err);
}

ost_status perform_import(performer *p, ost_error *err)
{
    ost_grid *rect = NULL, *cubic = NULL, *again = NULL;
    ost_status status = run_rect(p, &rect, err);
    if (p->refused) {
        ost_grid_free(rect);
        return status;
    }
    if (status == OST_OK)
        status = perform_give_grid(p, TRACE_RECT, rect, err);
    if (status == OST_OK)
        status = run_cubic(p, rect, &cubic, &again, err);
    if (status == OST_OK)
        status = perform_give_grid(p, TRACE_CUBIC, cubic, err);
    if (status == OST_OK && !before_the_download(p))
        status = make_again(p, cubic, &again, err);
    if (status == OST_OK)
        status = again ? record_cubic(p, TRACE_RESAMPLE, again, err) : record_no_grid(p, TRACE_RESAMPLE, err);
    ost_grid_free(again);
    if (status == OST_OK && !before_the_download(p))
        status = make_bone(p, cubic, err);
    if (status == OST_OK) {
        p->geometry = p->second ? steps_cubic(&p->s->rect, p->s->cubic) : *ost_grid_geometry(cubic);
        p->dims = ost_grid_geometry(cubic)->dims;
        const size_t bytes = (size_t)ost_dims_count(p->dims) * 2;
        p->was = malloc(bytes);
        p->is = malloc(bytes);
        status = p->was && p->is ? perform_record_bone(p, TRACE_CHUNKS, err)
                                 : ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
    }
    if (status == OST_OK)
        status = perform_give_bone(p, err);
    if (status == OST_OK)
        status = perform_sample(p, 0, err);
    if (status == OST_OK)
        status = perform_upload(p, err);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return status;
}
