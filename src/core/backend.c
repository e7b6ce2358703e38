/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the interface to the backends. Lists the backends, selects a backend by a string, and checks all arguments
 * before it calls a slot of the function table.
 */
#include "core/backend.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"

static const ost_backend_ops *const backends[] = {
    &ost_backend_cpu,
    &ost_backend_ref,
    &ost_backend_cl,
    &ost_backend_plugin,
};

enum { BACKEND_COUNT = sizeof backends / sizeof backends[0] };

/* ---------------------------------------------------------------- choice */

int ost_backend_count(void)
{
    return BACKEND_COUNT;
}

ost_status ost_backend_describe(int index, ost_backend_info *out, ost_error *err)
{
    if (index < 0 || index >= BACKEND_COUNT)
        return ost_fail(err, OST_ERR_USAGE, "backend %d; there are %d", index, BACKEND_COUNT);
    *out = (ost_backend_info){.name = backends[index]->name, .description = backends[index]->description};
    out->available = backends[index]->available(out->reason, sizeof out->reason);
    return OST_OK;
}

ost_status ost_backend_devices(int index, ost_device_visit *visit, void *user, ost_error *err)
{
    if (index < 0 || index >= BACKEND_COUNT || !visit)
        return ost_fail(err, OST_ERR_USAGE, "devices of backend %d; there are %d backends", index, BACKEND_COUNT);
    return backends[index]->devices(visit, user, err);
}

static const ost_backend_ops *find_backend(const char *name, size_t length)
{
    for (int i = 0; i < BACKEND_COUNT; i++)
        if (strlen(backends[i]->name) == length && memcmp(backends[i]->name, name, length) == 0)
            return backends[i];
    return NULL;
}

static ost_status unknown_backend(const char *spec, ost_error *err)
{
    char names[256] = "";
    for (int i = 0; i < BACKEND_COUNT; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s",
                 !i                       ? ""
                 : i == BACKEND_COUNT - 1 ? " or "
                                          : ", ",
                 backends[i]->name);
    }
    return ost_fail(err, OST_ERR_USAGE, "unknown backend '%.80s'; expected %s", spec, names);
}

ost_status ost_backend_open(const char *spec, ost_backend **out, ost_error *err)
{
    *out = NULL;
    if (!spec)
        return ost_fail(err, OST_ERR_USAGE, "no backend given");
    size_t length = strcspn(spec, ":");
    const ost_backend_ops *ops = find_backend(spec, length);
    if (!ops)
        return unknown_backend(spec, err);
    char reason[256] = "";
    if (!ops->available(reason, sizeof reason))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "backend '%s' is not available: %s", ops->name, reason);
    ost_status status = ops->open(spec[length] ? spec + length + 1 : "", out, err);
    if (status == OST_OK)
        (*out)->ops = ops;
    return status;
}

void ost_backend_close(ost_backend *backend)
{
    if (backend)
        backend->ops->close(backend);
}

const char *ost_backend_name(const ost_backend *backend)
{
    return backend->ops->name;
}

ost_backend_settings ost_backend_settings_get(const ost_backend *backend)
{
    return backend->ops->settings(backend);
}

ost_status ost_backend_finish(ost_backend *backend, ost_error *err)
{
    if (!backend)
        return ost_fail(err, OST_ERR_USAGE, "no backend given");
    return backend->ops->finish(backend, err);
}

void ost_backend_paths(const ost_backend *backend, ost_path_visit *visit, void *user)
{
    backend->ops->paths(backend, visit, user);
}

/* ----------------------------------------------------------------- grids */

static ost_status check_slices(const ost_geometry *geometry, int32_t z0, int32_t count, const void *voxels,
                               ost_error *err)
{
    if (z0 < 0 || count < 0 || z0 > geometry->dims.z || count > geometry->dims.z - z0)
        return ost_fail(err, OST_ERR_USAGE, "slices %d to %d of a grid that has %d", (int)z0, (int)z0 + (int)count,
                        (int)geometry->dims.z);
    if (!voxels)
        return ost_fail(err, OST_ERR_USAGE, "no voxels given");
    return OST_OK;
}

ost_status ost_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    *out = NULL;
    ost_status status = ost_geometry_check(geometry, "grid", err);
    return status == OST_OK ? backend->ops->grid_create(backend, geometry, out, err) : status;
}

void ost_grid_free(ost_grid *grid)
{
    if (grid)
        grid->backend->ops->grid_free(grid);
}

const ost_geometry *ost_grid_geometry(const ost_grid *grid)
{
    return &grid->geometry;
}

ost_status ost_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    ost_status status = check_slices(&grid->geometry, z0, count, voxels, err);
    return status == OST_OK ? grid->backend->ops->grid_upload(grid, z0, count, voxels, err) : status;
}

ost_status ost_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    ost_status status = check_slices(&grid->geometry, z0, count, voxels, err);
    return status == OST_OK ? grid->backend->ops->grid_download(grid, z0, count, voxels, err) : status;
}

/* ---------------------------------------------------------------- import */

ost_status ost_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                          ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    if (!samples || !report || (int)duplicates < OST_DUPLICATES_ERROR || duplicates > OST_DUPLICATES_MAX)
        return ost_fail(err, OST_ERR_USAGE, "samples, a report and a rule for duplicates are needed");
    for (size_t i = 0; i < count; i++)
        if (samples[i].density < INT16_MIN || samples[i].density > INT16_MAX)
            return ost_fail(err, OST_ERR_RANGE, "line %lld: a density of %d; expected -32768 to 32767",
                            (long long)(first_line + samples[i].line), (int)samples[i].density);
    return rect->backend->ops->ct_to_rect(rect, samples, count, first_line, duplicates, report, err);
}

/* Returns ceil(dim * rect / cubic). dim < 2^15 and rect < 2^37, so the product fits in int64. */
static int64_t cubic_dim(int32_t dim, ost_pm rect, ost_pm cubic)
{
    return ost_ceil_div(dim * rect, cubic);
}

/*
 * Returns the origin of the cubic grid (AR-CUB-1). The corner of the grid's box lies half a rect voxel before the first
 * centre of the rect grid, and the first centre of the cubic grid lies half a cubic voxel inside that corner. |origin|
 * < 2^43 and spacing < 2^37, so the sum fits in int64.
 */
static ost_pm cubic_origin(ost_pm origin, ost_pm rect, ost_pm cubic)
{
    return origin + ost_rhe_div(cubic - rect, 2);
}

const char *ost_resample_name(ost_resample rule)
{
    static const char *const names[] = {
        [OST_RESAMPLE_LINEAR] = "linear", [OST_RESAMPLE_NEAREST] = "nearest", [OST_RESAMPLE_THESIS] = "thesis"};
    return (int)rule >= OST_RESAMPLE_LINEAR && rule <= OST_RESAMPLE_THESIS ? names[rule] : NULL;
}

ost_status ost_rect_to_cubic(const ost_grid *rect, ost_pm cubic, ost_resample rule, ost_grid **out, ost_error *err)
{
    *out = NULL;
    const ost_geometry *g = &rect->geometry;
    char text[OST_PM_TEXT];
    if (cubic < OST_SPACING_MIN || cubic > OST_SPACING_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a cubic voxel of %s mm; expected 0.001 to 100 mm", ost_pm_format(cubic,
                        text));
    if (!ost_resample_name(rule))
        return ost_fail(err, OST_ERR_USAGE, "unknown rule %d for resampling", (int)rule);
    int64_t dims[3] = {
        cubic_dim(g->dims.x, g->spacing.x, cubic),
        cubic_dim(g->dims.y, g->spacing.y, cubic),
        cubic_dim(g->dims.z, g->spacing.z, cubic),
    };
    for (int a = 0; a < 3; a++)
        if (dims[a] > OST_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE,
                            "a cubic voxel of %s mm gives %lld voxels along %c; expected at most %d",
                            ost_pm_format(cubic, text), (long long)dims[a], "xyz"[a], OST_DIM_MAX);
    ost_geometry geometry = {
        .dims = {(int32_t)dims[0], (int32_t)dims[1], (int32_t)dims[2]},
        .spacing = {cubic, cubic, cubic},
        .origin = {cubic_origin(g->origin.x, g->spacing.x, cubic), cubic_origin(g->origin.y, g->spacing.y, cubic),
                   cubic_origin(g->origin.z, g->spacing.z, cubic)},
    };
    ost_status status = ost_geometry_check(&geometry, "cubic grid", err);
    return status == OST_OK ? rect->backend->ops->rect_to_cubic(rect, &geometry, rule, out, err) : status;
}

static ost_status check_bone(const ost_geometry *geometry, int chunk_size, int32_t threshold, ost_error *err)
{
    if (geometry->spacing.x != geometry->spacing.y || geometry->spacing.x != geometry->spacing.z)
        return ost_fail(err, OST_ERR_USAGE, "voxels of %.9g x %.9g x %.9g mm; a bone needs cubic voxels",
                        ost_pm_to_mm(geometry->spacing.x), ost_pm_to_mm(geometry->spacing.y),
                        ost_pm_to_mm(geometry->spacing.z));
    if (chunk_size != 16 && chunk_size != 32 && chunk_size != 64)
        return ost_fail(err, OST_ERR_USAGE, "chunks of %d voxels; expected 16, 32 and 64", chunk_size);
    if (threshold < 1 || threshold > INT16_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a threshold of %d; expected 1 to %d", (int)threshold, INT16_MAX);
    return OST_OK;
}

ost_status ost_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err)
{
    *out = NULL;
    ost_status status = check_bone(&cubic->geometry, chunk_size, threshold, err);
    return status == OST_OK ? cubic->backend->ops->cubic_to_chunks(cubic, chunk_size, threshold, out, err) : status;
}

/* ----------------------------------------------------------------- bones */

ost_status ost_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                           ost_bone **out, ost_error *err)
{
    *out = NULL;
    ost_status status = ost_geometry_check(geometry, "bone", err);
    if (status == OST_OK)
        status = check_bone(geometry, chunk_size, threshold, err);
    return status == OST_OK ? backend->ops->bone_create(backend, geometry, chunk_size, threshold, out, err) : status;
}

void ost_bone_free(ost_bone *bone)
{
    if (bone)
        bone->backend->ops->bone_free(bone);
}

ost_status ost_bone_info_get(const ost_bone *bone, ost_bone_info *out, ost_error *err)
{
    int32_t n = bone->chunk_size;
    ost_dims d = bone->geometry.dims;
    *out = (ost_bone_info){
        .geometry = bone->geometry,
        .chunk_size = n,
        .threshold = bone->threshold,
        .chunk_dims = {(d.x + n - 1) / n, (d.y + n - 1) / n, (d.z + n - 1) / n},
    };
    out->chunks = ost_dims_count(out->chunk_dims);
    return bone->backend->ops->bone_stats(bone, out, err);
}

ost_status ost_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    ost_status status = check_slices(&bone->geometry, z0, count, voxels, err);
    return status == OST_OK ? bone->backend->ops->bone_upload(bone, z0, count, voxels, err) : status;
}

ost_status ost_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    ost_status status = check_slices(&bone->geometry, z0, count, voxels, err);
    return status == OST_OK ? bone->backend->ops->bone_download(bone, z0, count, voxels, err) : status;
}

ost_status ost_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                           ost_error *err)
{
    if (!bone || (count > 0 && (!at || !densities)))
        return ost_fail(err, OST_ERR_USAGE, "sampling needs a bone, voxels and an array for their densities");
    return bone->backend->ops->bone_sample(bone, count, at, densities, err);
}

ost_status ost_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                              ost_error *err)
{
    if (!bone || (count > 0 && (!chunks || !words)))
        return ost_fail(err, OST_ERR_USAGE, "occupancy needs a bone, chunks and an array for their words");
    const int32_t n = bone->chunk_size;
    const ost_dims d = bone->geometry.dims;
    const int64_t all = (int64_t)((d.x + n - 1) / n) * ((d.y + n - 1) / n) * ((d.z + n - 1) / n);
    for (size_t i = 0; i < count; i++)
        if (chunks[i] < 0 || chunks[i] >= all)
            return ost_fail(err, OST_ERR_USAGE, "no chunk %d; the bone has %lld", (int)chunks[i], (long long)all);
    return bone->backend->ops->bone_occupancy(bone, count, chunks, words, err);
}

ost_status ost_bone_digest(const ost_bone *bone, ost_digest *leaves, ost_digest *root, ost_error *err)
{
    size_t count = (size_t)ost_dims_count(ost_leaf_dims(bone->geometry.dims));
    ost_digest *own = leaves ? NULL : malloc(count * sizeof *own);
    ost_digest *all = leaves ? leaves : own;
    if (!all)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu digests", count);
    ost_status status = bone->backend->ops->bone_leaves(bone, all, err);
    if (status == OST_OK && root)
        status = ost_digest_root(OST_GRID_BONE, &bone->geometry, bone->threshold, all, count, root, err);
    free(own);
    return status;
}

/* ----------------------------------------------------------------- tools */

static bool same_tool_grid(const ost_tool_geometry *a, const ost_tool_geometry *b)
{
    return a->dims.x == b->dims.x && a->dims.y == b->dims.y && a->dims.z == b->dims.z && a->voxel == b->voxel &&
           a->corner.x == b->corner.x && a->corner.y == b->corner.y && a->corner.z == b->corner.z;
}

ost_status ost_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                        ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    *out = NULL;
    ost_voxelize_report ignored;
    ost_status status = ost_tool_geometry_check(&cutting->grid, err);
    if (status != OST_OK)
        return status;
    if (noncutting &&
        (!same_tool_grid(&cutting->grid, &noncutting->grid) || cutting->fraction_bits != noncutting->fraction_bits))
        return ost_fail(err, OST_ERR_USAGE, "the cutting and the non-cutting mesh must be snapped to the same grid");
    if (rule != OST_FILL_WINDING && rule != OST_FILL_PARITY)
        return ost_fail(err, OST_ERR_USAGE, "unknown rule %d for filling", (int)rule);
    return backend->ops->voxelize(backend, cutting, noncutting, rule, report ? report : &ignored, out, err);
}

ost_status ost_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    *out = NULL;
    ost_status status = ost_tool_geometry_check(&volume->geometry, err);
    if (status != OST_OK)
        return status;
    int64_t count = ost_dims_count(volume->geometry.dims);
    for (int64_t i = 0; i < count; i++)
        if (volume->voxels[i] > OST_TOOL_NONCUTTING)
            return ost_fail(err, OST_ERR_INPUT,
                            "tool voxel %lld has class %d; expected 0 (void), 1 (cutting) or 2 (not cutting)",
                            (long long)i, volume->voxels[i]);
    return backend->ops->tool_upload(backend, volume, out, err);
}

ost_status ost_tool_download(const ost_tool *tool, ost_tool_volume *out, ost_error *err)
{
    ost_status status = ost_tool_volume_init(out, &tool->geometry, err);
    if (status == OST_OK)
        status = tool->backend->ops->tool_download(tool, out, err);
    if (status != OST_OK)
        ost_tool_volume_free(out);
    return status;
}

void ost_tool_free(ost_tool *tool)
{
    if (tool)
        tool->backend->ops->tool_free(tool);
}

const ost_tool_geometry *ost_tool_geometry_get(const ost_tool *tool)
{
    return &tool->geometry;
}

ost_status ost_tool_digest(const ost_tool *tool, ost_digest *root, ost_error *err)
{
    ost_tool_volume volume;
    ost_status status = ost_tool_download(tool, &volume, err);
    if (status != OST_OK)
        return status;
    const ost_tool_geometry *g = &volume.geometry;
    ost_geometry geometry = {g->dims, {g->voxel, g->voxel, g->voxel}, g->corner};
    status = ost_digest_dense(OST_GRID_TOOL, &geometry, volume.voxels, 1, root, err);
    ost_tool_volume_free(&volume);
    return status;
}

/* ---------------------------------------------------------------- events */

static ost_status check_event(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                              ost_removal_report *report, ost_error *err)
{
    if (!tool || !event || !report)
        return ost_fail(err, OST_ERR_USAGE, "a tool, an event and a report are needed");
    if (bone->backend != tool->backend)
        return ost_fail(err, OST_ERR_USAGE, "bone and tool are on different backends");
    if (event->pose_count < 1 || event->pose_count > OST_SWEEP_MAX || !event->maps || !event->boxes || !event->classes)
        return ost_fail(err, OST_ERR_USAGE, "an event of %d poses; it needs 1 to %d, with maps, boxes and classes",
                        event->pose_count, OST_SWEEP_MAX);
    const ost_dims d = tool->geometry.dims;
    if (d.x > OST_TOOL_DIM_REMOVE_MAX || d.y > OST_TOOL_DIM_REMOVE_MAX || d.z > OST_TOOL_DIM_REMOVE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a tool of %d x %d x %d voxels; removal takes at most %d along an axis",
                        (int)d.x, (int)d.y, (int)d.z, OST_TOOL_DIM_REMOVE_MAX);
    /* The borders must be ascending, because a backend may search the list for a voxel's class from either end. */
    return ost_density_classes_check(event->classes, err);
}

ost_status ost_bone_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                           ost_removal_report *report, ost_error *err)
{
    ost_status status = check_event(bone, tool, event, report, err);
    if (status != OST_OK)
        return status;
    ost_removal_report_clear(report);
    return bone->backend->ops->remove(bone, tool, event, report, err);
}

ost_status ost_bone_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                            ost_removal_report *report, ost_error *err)
{
    ost_status status = check_event(bone, tool, event, report, err);
    if (status != OST_OK)
        return status;
    ost_removal_report_clear(report);
    return bone->backend->ops->collide(bone, tool, event, report, err);
}
