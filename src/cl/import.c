/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts samples to a rect grid, and a rect grid to a cubic grid, on the device
 * (AR-CT-4..6, AR-CUB).
 *
 * A batch of samples is uploaded in parts of at most PART_BYTES.  The kernels process each
 * part as a separate batch, so the reports of parts are combined in the same way as the
 * reports of batches (see kernels/shared.h).  All parts have the first_line of the batch.
 * The host reads a report of 32 bytes per part.  Two further kernels run only if there is
 * a conflict.
 */
#include "cl/objects.h"

#include <assert.h>
#include <stdlib.h>

enum { PART_BYTES = (1 << 21) * sizeof(ost_sample) };

static ost_cl_scatter scatter_of(const ost_geometry *g, ost_duplicates duplicates, size_t count)
{
    return (ost_cl_scatter){
        .origin = {g->origin.x, g->origin.y, g->origin.z},
        .spacing = {g->spacing.x, g->spacing.y, g->spacing.z},
        .dims = {g->dims.x, g->dims.y, g->dims.z},
        .duplicates = (int32_t)duplicates,
        .count = (uint32_t)count,
    };
}

static bool earlier(int64_t line, int64_t recorded)
{
    return recorded == 0 || line < recorded;
}

/* Adds the report of one part of a batch to the report of the batch. */
static void add_part(ost_scatter_report *total, const ost_cl_scatter_report *part, const ost_sample *samples,
                     size_t count, int64_t first_line)
{
    total->samples += count;
    total->duplicates += part->duplicates;
    total->off_lattice += part->off_lattice;
    if (part->worst_ppm > 0 &&
        (part->worst_ppm > total->worst_offset_ppm ||
         (part->worst_ppm == total->worst_offset_ppm && earlier(first_line + part->worst_line, total->worst_line)))) {
        total->worst_offset_ppm = part->worst_ppm;
        total->worst_line = first_line + part->worst_line;
    }
    if (part->rejected_line != OST_CL_NONE && earlier(first_line + part->rejected_line, total->rejected_line))
        total->rejected_line = first_line + part->rejected_line;
    if (part->conflict_line != OST_CL_NONE && part->conflict_index < count &&
        earlier(first_line + part->conflict_line, total->conflict_line)) {
        total->conflict_line = first_line + part->conflict_line;
        total->conflict_had = (int16_t)part->conflict_had;
        total->conflict_has = (int16_t)samples[part->conflict_index].density;
    }
}

static ost_status run_part(cl_grid *grid, const ost_sample *samples, size_t count, ost_duplicates duplicates,
                           ost_cl_scatter_report *part, ost_error *err)
{
    cl_backend *b = (cl_backend *)grid->base.backend;
    const ost_cl_scatter scatter = scatter_of(&grid->base.geometry, duplicates, count);
    *part = (ost_cl_scatter_report){.worst_line = OST_CL_NONE,
                                    .rejected_line = OST_CL_NONE,
                                    .conflict_line = OST_CL_NONE,
                                    .conflict_index = OST_CL_NONE};
    cl_mem scatter_buffer = NULL, sample_buffer = NULL, report = NULL;
    ost_status status = ost_cl_buffer(b, sizeof scatter, &scatter, "samples", &scatter_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, count * sizeof *samples, samples, "samples", &sample_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof *part, part, "samples", &report, err);
    bool changed = false;
    if (status == OST_OK) {
        status = OST_CL_LAUNCH(b, ost_ct_claim, count, 1, 1, err, OST_CL_ARG(scatter_buffer), OST_CL_ARG(sample_buffer),
                               OST_CL_ARG(grid->seen), OST_CL_ARG(grid->owner), OST_CL_ARG(report));
        changed = status == OST_OK;
    }
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_ct_place, count, 1, 1, err, OST_CL_ARG(scatter_buffer), OST_CL_ARG(sample_buffer),
                               OST_CL_ARG(grid->seen), OST_CL_ARG(grid->owner), OST_CL_ARG(grid->store->voxels),
                               OST_CL_ARG(report));
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_ct_check, count, 1, 1, err, OST_CL_ARG(scatter_buffer), OST_CL_ARG(sample_buffer),
                               OST_CL_ARG(grid->seen), OST_CL_ARG(grid->owner), OST_CL_ARG(grid->store->voxels),
                               OST_CL_ARG(report));
    if (status == OST_OK)
        status = ost_cl_read(b, report, 0, sizeof *part, part, err);
    if (status == OST_OK && part->conflict_line != OST_CL_NONE) {
        status = OST_CL_LAUNCH(b, ost_ct_report_first_bad, count, 1, 1, err, OST_CL_ARG(scatter_buffer),
                               OST_CL_ARG(sample_buffer), OST_CL_ARG(grid->store->voxels), OST_CL_ARG(report));
        if (status == OST_OK)
            status = OST_CL_LAUNCH(b, ost_ct_had, 1, 1, 1, err, OST_CL_ARG(scatter_buffer), OST_CL_ARG(sample_buffer),
                                   OST_CL_ARG(grid->store->voxels), OST_CL_ARG(report));
        if (status == OST_OK)
            status = ost_cl_read(b, report, 0, sizeof *part, part, err);
    }
    grid->lost = grid->lost || (changed && status != OST_OK);
    ost_cl_buffer_free(b, &report);
    ost_cl_buffer_free(b, &sample_buffer);
    ost_cl_buffer_free(b, &scatter_buffer);
    return status;
}

ost_status ost_cl_ct_to_rect(ost_grid *base, const ost_sample *samples, size_t count, int64_t first_line,
                             ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    cl_grid *grid = (cl_grid *)base;
    cl_backend *b = (cl_backend *)base->backend;
    const size_t voxels = (size_t)ost_dims_count(base->geometry.dims);
    ost_status status = ost_cl_alive(base->backend, grid->lost, "grid", err);
    if (status == OST_OK)
        status = ost_cl_grid_own(grid, err);
    if (status == OST_OK && !grid->seen)
        status = ost_cl_buffer_zero(b, (voxels + 31) / 32 * sizeof(uint32_t), "which voxels are set", &grid->seen, err);
    if (status == OST_OK && !grid->owner)
        status = ost_cl_buffer_zero(b, voxels * sizeof(uint32_t), "which sample sets a voxel", &grid->owner, err);
    const size_t most = ost_cl_staging(b, PART_BYTES) / sizeof *samples;
    b->entered[OST_CL_PATH_SAMPLES_IN_PARTS] += count > most;
    ost_scatter_report total = *report;
    for (size_t done = 0; done < count && status == OST_OK;) {
        const size_t now = count - done < most ? count - done : most;
        ost_cl_scatter_report part;
        status = run_part(grid, samples + done, now, duplicates, &part, err);
        if (status == OST_OK)
            add_part(&total, &part, samples + done, now, first_line);
        else if (done > 0)
            grid->lost = true; /* the parts before the failure have already changed the grid */
        done += now;
    }
    if (status == OST_OK)
        *report = total;
    return status;
}

ost_status ost_cl_rect_to_cubic(const ost_grid *base, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                ost_error *err)
{
    /* The function casts away const, because the result may share the store of the grid. No voxel changes. */
    cl_grid *rect = (cl_grid *)(uintptr_t)base;
    cl_backend *b = (cl_backend *)base->backend;
    const ost_geometry *r = &base->geometry;
    const ost_cl_cubic cubic = {
        .rect_spacing = {r->spacing.x, r->spacing.y, r->spacing.z},
        .cubic_spacing = {geometry->spacing.x, geometry->spacing.y, geometry->spacing.z},
        .rect_dims = {r->dims.x, r->dims.y, r->dims.z},
        .dims = {geometry->dims.x, geometry->dims.y, geometry->dims.z},
        .rule = (int32_t)rule,
        .z0 = 0,
        .z1 = geometry->dims.z,
    };
    /*
     * Along an axis on which the two grids have the same spacing, every resampling rule computes a voxel only from the
     * source voxel with the same index; the weight of the upper neighbour is 0.
     */
    const bool z_alone = geometry->spacing.x == r->spacing.x && geometry->spacing.y == r->spacing.y;
    const bool linear = rule == OST_RESAMPLE_LINEAR;
    const size_t axes = (size_t)geometry->dims.x + (size_t)geometry->dims.y + (size_t)geometry->dims.z;
    cl_mem cubic_buffer = NULL, sources = NULL;
    ost_grid *to = NULL;
    ost_status status = ost_cl_alive(base->backend, rect->lost, "grid", err);
    if (status == OST_OK && rect->sources)
        status = ost_cl_grid_own(rect, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof cubic, &cubic, "resampling", &cubic_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, 2 * axes * sizeof(int32_t), NULL, "resampling", &sources, err);
    if (status == OST_OK)
        /* The buffer need not be initialised, because the kernel writes every voxel. */
        status = ost_cl_grid_create_raw(base->backend, geometry, z_alone ? rect->store : NULL, &to, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_cubic_sources, axes, 1, 1, err, OST_CL_ARG(cubic_buffer), OST_CL_ARG(sources));
    b->entered[z_alone ? OST_CL_PATH_RESAMPLED_LATER : OST_CL_PATH_RESAMPLED_NOW]++;
    if (status == OST_OK && !z_alone)
        status = ost_cl_resample(b, geometry->dims, linear, cubic_buffer, sources, rect->store->voxels,
                                 ((cl_grid *)to)->store->voxels, err);
    if (status == OST_OK) /* ost_cl_finish also returns the errors of commands that were enqueued earlier. */
        status = ost_cl_finish(b, err);
    if (status == OST_OK && z_alone) {
        ((cl_grid *)to)->cubic = cubic_buffer;
        ((cl_grid *)to)->sources = sources;
        ((cl_grid *)to)->linear = linear;
        cubic_buffer = sources = NULL;
    }
    ost_cl_buffer_free(b, &sources);
    ost_cl_buffer_free(b, &cubic_buffer);
    if (status != OST_OK) {
        if (to)
            ost_cl_grid_free(to);
        return status;
    }
    *out = to;
    return OST_OK;
}
