/* SPDX-License-Identifier: Apache-2.0 */
/* The grids of a plugin, and the first two stages of the import. */
#include "plugin/adapt.h"

#include <stdlib.h>

_Static_assert(sizeof(ost_plugin_sample) == 32 && sizeof(ost_sample) == sizeof(ost_plugin_sample),
               "samples are handed over as they are");
_Static_assert(offsetof(ost_sample, density) == offsetof(ost_plugin_sample, density) &&
                   offsetof(ost_sample, line) == offsetof(ost_plugin_sample, line),
               "samples are handed over as they are");

_Static_assert((int)OST_PLUGIN_LINEAR == (int)OST_RESAMPLE_LINEAR &&
                   (int)OST_PLUGIN_NEAREST == (int)OST_RESAMPLE_NEAREST &&
                   (int)OST_PLUGIN_THESIS == (int)OST_RESAMPLE_THESIS,
               "rules for resampling");

static ost_status new_grid(ost_backend *backend, const ost_geometry *geometry, plugin_grid **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid");
    (*out)->base = (ost_grid){.backend = backend, .geometry = *geometry};
    return OST_OK;
}

/* Called after the plugin's function `slot`, which creates a grid. On success, sets *out to the grid. On an error,
   frees the grid and returns the error. */
static ost_status made_grid(plugin_grid *grid, const char *slot, ost_status status, ost_grid **out, ost_error *err)
{
    if (status == OST_OK && !grid->own)
        status = ost_adapt_no_object(adapt_backend(grid->base.backend), slot, err);
    if (status != OST_OK) {
        free(grid);
        return status;
    }
    *out = &grid->base;
    return OST_OK;
}

ost_status ost_adapt_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    const ost_plugin_geometry g = ost_adapt_geometry(geometry);
    plugin_grid *grid;
    plugin_error_sink t;
    ost_status status = new_grid(backend, geometry, &grid, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(b, "grid_create",
                             b->table.grid_create(b->self, &g, &grid->own, &adapt_listening(&t)->error), &t, NULL, err);
    return made_grid(grid, "grid_create", status, out, err);
}

void ost_adapt_grid_free(ost_grid *base)
{
    plugin_grid *grid = (plugin_grid *)base;
    adapt_table(base->backend)->grid_free(grid->own);
    free(grid);
}

ost_status ost_adapt_grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    plugin_grid *grid = (plugin_grid *)base;
    plugin_backend *b = adapt_backend(base->backend);
    plugin_error_sink t;
    if (grid->lost)
        return ost_adapt_is_lost(b, err);
    return ost_adapt_heard(b, "grid_upload",
                           b->table.grid_upload(grid->own, z0, count, voxels, &adapt_listening(&t)->error), &t,
                           &grid->lost, err);
}

ost_status ost_adapt_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    const plugin_grid *grid = (const plugin_grid *)base;
    plugin_backend *b = adapt_backend(base->backend);
    plugin_error_sink t;
    if (grid->lost)
        return ost_adapt_is_lost(b, err);
    return ost_adapt_heard(b, "grid_download",
                           b->table.grid_download(grid->own, z0, count, voxels, &adapt_listening(&t)->error), &t, NULL,
                           err);
}

/* ----------------------------------------------------------------- import */

ost_status ost_adapt_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                                ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    plugin_grid *grid = (plugin_grid *)rect;
    plugin_backend *b = adapt_backend(rect->backend);
    ost_plugin_scatter_report r = {.size = sizeof r,
                                   .conflict_had = report->conflict_had,
                                   .conflict_has = report->conflict_has,
                                   .samples = report->samples,
                                   .duplicates = report->duplicates,
                                   .off_lattice = report->off_lattice,
                                   .worst_offset_ppm = report->worst_offset_ppm,
                                   .worst_line = report->worst_line,
                                   .rejected_line = report->rejected_line,
                                   .conflict_line = report->conflict_line};
    const ost_plugin_samples batch = {.size = sizeof batch,
                                      .duplicates = (int32_t)duplicates,
                                      .count = count,
                                      .first_line = first_line,
                                      .sample = (const ost_plugin_sample *)(const void *)samples};
    plugin_error_sink t;
    if (grid->lost)
        return ost_adapt_is_lost(b, err);
    ost_status status = ost_adapt_heard(
        b, "ct_to_rect", b->table.ct_to_rect(grid->own, &batch, &r, &adapt_listening(&t)->error), &t, &grid->lost, err);
    if (status == OST_OK)
        *report = (ost_scatter_report){.samples = r.samples,
                                       .duplicates = r.duplicates,
                                       .off_lattice = r.off_lattice,
                                       .worst_offset_ppm = r.worst_offset_ppm,
                                       .worst_line = r.worst_line,
                                       .rejected_line = r.rejected_line,
                                       .conflict_line = r.conflict_line,
                                       .conflict_had = r.conflict_had,
                                       .conflict_has = r.conflict_has};
    return status;
}

ost_status ost_adapt_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule,
                                   ost_grid **out, ost_error *err)
{
    const plugin_grid *from = (const plugin_grid *)rect;
    plugin_backend *b = adapt_backend(rect->backend);
    const ost_plugin_geometry g = ost_adapt_geometry(geometry);
    plugin_grid *grid;
    plugin_error_sink t;
    ost_status status = from->lost ? ost_adapt_is_lost(b, err) : new_grid(rect->backend, geometry, &grid, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(
        b, "rect_to_cubic",
        b->table.rect_to_cubic(from->own, &g, (int32_t)rule, &grid->own, &adapt_listening(&t)->error), &t, NULL, err);
    return made_grid(grid, "rect_to_cubic", status, out, err);
}
