/* SPDX-License-Identifier: Apache-2.0 */
/* The tools of a plugin. A tool is voxelized by the plugin or uploaded to the plugin. */
#include "plugin/adapt.h"

#include <stdlib.h>

ost_plugin_tool_geometry ost_adapt_tool_geometry(const ost_tool_geometry *g)
{
    return (ost_plugin_tool_geometry){.size = sizeof(ost_plugin_tool_geometry),
                                      .dims = {g->dims.x, g->dims.y, g->dims.z},
                                      .voxel_pm = g->voxel,
                                      .corner_pm = {g->corner.x, g->corner.y, g->corner.z}};
}

static ost_status new_tool(ost_backend *backend, const ost_tool_geometry *geometry, plugin_tool **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool");
    (*out)->base = (ost_tool){.backend = backend, .geometry = *geometry};
    return OST_OK;
}

static ost_status made_tool(plugin_tool *tool, const char *slot, ost_status status, ost_tool **out, ost_error *err)
{
    if (status == OST_OK && !tool->own)
        status = ost_adapt_no_object(adapt_backend(tool->base.backend), slot, err);
    if (status != OST_OK) {
        free(tool);
        return status;
    }
    *out = &tool->base;
    return OST_OK;
}

static ost_plugin_mesh mesh_of(const ost_snapped_mesh *m)
{
    return (ost_plugin_mesh){.size = sizeof(ost_plugin_mesh),
                             .fraction_bits = m->fraction_bits,
                             .vertex_count = m->vertex_count,
                             .triangle_count = m->triangle_count,
                             .vertices = m->vertex_count ? m->vertices[0] : NULL,
                             .triangles = m->triangle_count ? m->triangles[0] : NULL};
}

ost_status ost_adapt_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                              ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    const ost_plugin_tool_geometry g = ost_adapt_tool_geometry(&cutting->grid);
    const ost_plugin_mesh first = mesh_of(cutting),
                          second = noncutting ? mesh_of(noncutting) : (ost_plugin_mesh){.size = sizeof second};
    ost_plugin_voxelize_report r = {.size = sizeof r};
    plugin_tool *tool;
    plugin_error_sink t;
    ost_status status = new_tool(backend, &cutting->grid, &tool, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(b, "voxelize",
                             b->table.voxelize(b->self, &g, &first, noncutting ? &second : NULL,
                                               rule == OST_FILL_PARITY, &r, &tool->own, &adapt_listening(&t)->error),
                             &t, NULL, err);
    *report = (ost_voxelize_report){
        .solid_voxels = r.solid_voxels, .cutting_voxels = r.cutting_voxels, .leaking_rows = r.leaking_rows};
    return made_tool(tool, "voxelize", status, out, err);
}

ost_status ost_adapt_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    const ost_plugin_tool_geometry g = ost_adapt_tool_geometry(&volume->geometry);
    plugin_tool *tool;
    plugin_error_sink t;
    ost_status status = new_tool(backend, &volume->geometry, &tool, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(b, "tool_upload",
                             b->table.tool_upload(b->self, &g, volume->voxels, &tool->own, &adapt_listening(&t)->error),
                             &t, NULL, err);
    return made_tool(tool, "tool_upload", status, out, err);
}

ost_status ost_adapt_tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err)
{
    const plugin_tool *tool = (const plugin_tool *)base;
    plugin_backend *b = adapt_backend(base->backend);
    plugin_error_sink t;
    return ost_adapt_heard(b, "tool_download",
                           b->table.tool_download(tool->own, volume->voxels, &adapt_listening(&t)->error), &t, NULL,
                           err);
}

void ost_adapt_tool_free(ost_tool *base)
{
    plugin_tool *tool = (plugin_tool *)base;
    adapt_table(base->backend)->tool_free(tool->own);
    free(tool);
}
