/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/text/rect.h"

#include <stdlib.h>

#include "core/integer.h"

enum { ROWS = 2048, BATCH = 32768 };
_Static_assert(BATCH % ROWS == 0, "a batch takes whole portions of rows");

typedef struct pass {
    const char *path;
    const ost_text_rect_options *options;
    ost_grid *rect;
    ost_scatter_report *report;
    ost_sample *samples; /* BATCH elements */
    size_t count;
    int64_t first_line;
} pass;

static ost_status changed(const char *path, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: file changed while it was read; try again when no program writes to it",
                    path);
}

/* ------------------------------------------------------------------ messages */

static const ost_sample *sample_of_line(const pass *p, int64_t line)
{
    for (size_t i = 0; i < p->count; i++)
        if (p->first_line + p->samples[i].line == line)
            return &p->samples[i];
    return NULL;
}

static ost_status fail_rejected(const pass *p, ost_error *err)
{
    const ost_sample *sample = sample_of_line(p, p->report->rejected_line);
    if (!sample)
        return changed(p->path, err);
    const ost_geometry *g = p->options->full;
    const int64_t at[3] = {sample->x, sample->y, sample->z};
    const int64_t origin[3] = {g->origin.x, g->origin.y, g->origin.z},
                  spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    for (int a = 0; a < 3; a++) {
        int64_t off = at[a] - origin[a] - ost_rhe_div(at[a] - origin[a], spacing[a]) * spacing[a];
        off = off < 0 ? -off : off;
        if (8 * off <= 3 * spacing[a])
            continue;
        char value[OST_PM_TEXT], step[OST_PM_TEXT], from[OST_PM_TEXT];
        return ost_fail(err, OST_ERR_INPUT,
                        "%s:%lld: %c = %s lies %.3f voxels off the lattice of %s mm from %s mm; expected at most "
                        "3/8; check the spacing", p->path, (long long)p->report->rejected_line, "xyz"[a],
                        ost_pm_format(at[a], value), (double)off / (double)spacing[a], ost_pm_format(spacing[a],
                        step), ost_pm_format(origin[a], from));
    }
    return changed(p->path, err); /* the sample is on the lattice, but outside the grid that the first pass found */
}

static ost_status fail_conflict(const pass *p, ost_error *err)
{
    const ost_sample *sample = sample_of_line(p, p->report->conflict_line);
    if (!sample)
        return changed(p->path, err);
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    return ost_fail(err, OST_ERR_INPUT,
                    "%s:%lld: density %d at (%s, %s, %s), where an earlier line has %d; choose one with "
                    "'osteon import --duplicates first', 'last' or 'max'", p->path,
                    (long long)p->report->conflict_line, (int)p->report->conflict_has, ost_pm_format(sample->x, x),
                    ost_pm_format(sample->y, y), ost_pm_format(sample->z, z), (int)p->report->conflict_had);
}

/* ---------------------------------------------------------------------- pass */

static ost_status flush(pass *p, ost_error *err)
{
    if (p->count == 0)
        return OST_OK;
    ost_scatter_report *report = p->report;
    ost_status status = ost_ct_to_rect(p->rect, p->samples, p->count, p->first_line, p->options->duplicates, report,
                                       err);
    if (status == OST_OK && report->rejected_line &&
        (!report->conflict_line || report->rejected_line < report->conflict_line))
        status = fail_rejected(p, err);
    else if (status == OST_OK && report->conflict_line)
        status = fail_conflict(p, err);
    p->count = 0;
    return status;
}

/*
 * Returns true if the row's voxel is within the crop. A position is within 8 m, so the difference from the origin is
 * below 2^54.
 */
static bool in_crop(const ost_geometry *full, const ost_voxel_box *crop, const ost_text_row *row)
{
    const int64_t origin[3] = {full->origin.x, full->origin.y, full->origin.z};
    const int64_t spacing[3] = {full->spacing.x, full->spacing.y, full->spacing.z};
    for (int a = 0; a < 3; a++) {
        int64_t index = ost_rhe_div(row->position[a] - origin[a], spacing[a]);
        if (index < crop->lo[a] || index >= crop->hi[a])
            return false;
    }
    return true;
}

static ost_status add_row(pass *p, const ost_text_row *row, ost_error *err)
{
    if (p->options->crop && !in_crop(p->options->full, p->options->crop, row))
        return OST_OK;
    /*
     * The lines of a batch are stored as 32-bit offsets. An offset can overflow only if 2 * 10^9 comment lines lie
     * between two samples.
     */
    if (p->count > 0 && row->line - p->first_line > INT32_MAX) {
        ost_status status = flush(p, err);
        if (status != OST_OK)
            return status;
    }
    if (p->count == 0)
        p->first_line = row->line;
    p->samples[p->count++] = (ost_sample){
        .x = row->position[0],
        .y = row->position[1],
        .z = row->position[2],
        .density = row->density,
        .line = (uint32_t)(row->line - p->first_line),
    };
    return p->count == BATCH ? flush(p, err) : OST_OK;
}

ost_status ost_text_to_rect(ost_text_source *source, const ost_text_rect_options *options, ost_grid *rect,
                            ost_scatter_report *report, ost_error *err)
{
    pass p = {.path = source->parser.path, .options = options, .rect = rect, .report = report};
    ost_text_fingerprint fingerprint = {0, 0};
    *report = (ost_scatter_report){0};
    ost_status status = ost_text_source_rewind(source, err);
    ost_text_row *rows = malloc(ROWS * sizeof *rows);
    p.samples = malloc(BATCH * sizeof *p.samples);
    if (status == OST_OK && (!rows || !p.samples))
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory to read %d lines", p.path, BATCH);
    size_t count = 1;
    for (unsigned batch = 0; status == OST_OK && count > 0; batch++) {
        status = ost_text_source_next(source, rows, ROWS, &count, err);
        for (size_t i = 0; i < count && status == OST_OK; i++)
            status = add_row(&p, &rows[i], err);
        if (status == OST_OK)
            ost_text_fingerprint_add(&fingerprint, rows, count);
        if (status == OST_OK && options->progress && batch % 64 == 0 &&
            !options->progress(options->user, "rect", ost_text_lines_share(source->lines)))
            status = ost_fail(err, OST_ERR_CANCELLED, "%s: reading was cancelled", p.path);
    }
    if (status == OST_OK)
        status = flush(&p, err);
    if (status == OST_OK && (fingerprint.rows != options->expected.rows || fingerprint.hash != options->expected.hash))
        status = changed(p.path, err);
    if (status == OST_OK && options->dims_line && report->duplicates > 0)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s:%lld: this line declares one sample per voxel, but %llu samples repeat a voxel; remove "
                          "this line or the repeated samples", p.path, (long long)options->dims_line,
                          (unsigned long long)report->duplicates);
    free(rows);
    free(p.samples);
    return status;
}
