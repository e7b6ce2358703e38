/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declarations shared by the files of the adapter. The adapter creates host objects that
 * refer to objects of a plugin, and checks the results of the plugin.
 *
 *   adapt.c        opening, closing, the table     adapt_grid.c   grids, import
 *   adapt_bone.c   bones, digests                  adapt_tool.c   tools
 *   adapt_event.c  events and their reports        adapt_steps.c  steps that the plugin executes itself
 *   adapt_status.c statuses, error texts, geometries
 *
 *   call --convert--> slot --check status, object, report--> result
 */
#ifndef OST_PLUGIN_ADAPT_H
#define OST_PLUGIN_ADAPT_H

#include "core/int128.h"
#include "plugin/plugin.h"

/* Converts a 128-bit integer from the plugin's type to the host's type. */
static inline ost_int128 ost_int128_of_plugin(ost_plugin_int128 value)
{
    return (ost_int128){.low = value.low, .high = value.high};
}

typedef struct plugin_backend {
    ost_backend base;
    ost_plugin table;
    ost_plugin_instance *self;
    char name[PLUGIN_NAME];
} plugin_backend;

/* A host object that refers to an object of the plugin. `lost` is true after a call on the object has failed
   part-way; the object may then only be freed. */
typedef struct plugin_grid {
    ost_grid base;
    ost_plugin_grid *own;
    bool lost;
} plugin_grid;

typedef struct plugin_bone {
    ost_bone base;
    ost_plugin_bone *own;
    bool lost;
} plugin_bone;

typedef struct plugin_tool {
    ost_tool base;
    ost_plugin_tool *own;
} plugin_tool;

static inline plugin_backend *adapt_backend(const ost_backend *backend)
{
    return (plugin_backend *)(uintptr_t)backend;
}

static inline const ost_plugin *adapt_table(const ost_backend *backend)
{
    return &adapt_backend(backend)->table;
}

/* ---------------------------------------------------------------- answers */

/* A buffer for the error text of a plugin. The host terminates the text, because a plugin might not do so. */
typedef struct plugin_error_sink {
    ost_plugin_error error;
    char text[400];
} plugin_error_sink;

static inline plugin_error_sink *adapt_listening(plugin_error_sink *t)
{
    *t = (plugin_error_sink){.error = {.size = sizeof t->error, .text_size = sizeof t->text, .text = t->text}};
    return t;
}

/*
 * Converts the status that a plugin's function returned to an ost_status, and copies the plugin's error text to err. If
 * the status is OST_PLUGIN_LOST, also sets *lost to true. `lost` may be NULL.
 */
ost_status ost_adapt_heard(const plugin_backend *b, const char *slot, int32_t status, plugin_error_sink *t, bool *lost,
                           ost_error *err);
ost_status ost_adapt_no_object(const plugin_backend *b, const char *slot, ost_error *err);
ost_status ost_adapt_is_lost(const plugin_backend *b, ost_error *err);

ost_plugin_geometry ost_adapt_geometry(const ost_geometry *g);
ost_plugin_tool_geometry ost_adapt_tool_geometry(const ost_tool_geometry *g);

/* ------------------------------------------------------------------ slots */
/* The slots of core/backend.h. */

ost_status ost_adapt_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
void ost_adapt_grid_free(ost_grid *base);
ost_status ost_adapt_grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_adapt_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_adapt_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                                ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
ost_status ost_adapt_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule,
                                   ost_grid **out, ost_error *err);
ost_status ost_adapt_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                     ost_error *err);
ost_status ost_adapt_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                                 ost_bone **out, ost_error *err);
void ost_adapt_bone_free(ost_bone *base);
ost_status ost_adapt_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err);
ost_status ost_adapt_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_adapt_bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_adapt_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err);
ost_status ost_adapt_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                              ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
ost_status ost_adapt_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_adapt_tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err);
void ost_adapt_tool_free(ost_tool *base);
/* ost_adapt_snap and ost_adapt_steps return OST_ERR_UNAVAILABLE if the plugin does not implement them. */
ost_status ost_adapt_snap(ost_backend *backend, const ost_mesh *mesh, const ost_tool_geometry *grid,
                          ost_snapped_mesh *out, ost_error *err);
ost_status ost_adapt_steps(ost_backend *backend, const ost_geometry *bone, const ost_tool_geometry *tool,
                           const ost_pose *from, const ost_pose *to, int *count, ost_pose *poses, ost_map *maps,
                           ost_error *err);
ost_status ost_adapt_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                            ost_removal_report *report, ost_error *err);
ost_status ost_adapt_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                             ost_removal_report *report, ost_error *err);

#endif
