/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/common/lab.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void lab_record(lab *l, const char *kind, const char *name, const char *requirements, const char *what, bool passed,
                const char *expected, const char *got, ...)
{
    char text[300];
    va_list args;
    va_start(args, got);
    vsnprintf(text, sizeof text, got, args);
    va_end(args);
    if (l->status != OST_OK)
        return;
    json_t *row = json_pack("{s:s,s:s,s:s,s:s,s:b,s:s,s:s}", "kind", kind, "name", name, "requirements", requirements,
                            "what", what, "passed", passed, "expected", expected, "got", text);
    if (!row || json_array_append_new(l->checks, row) != 0)
        l->status = ost_fail(l->err, OST_ERR_MEMORY, "out of memory for a check");
}

ost_geometry lab_cube(int32_t nx, int32_t ny, int32_t nz, ost_pm spacing)
{
    return (ost_geometry){.dims = {nx, ny, nz}, .spacing = {spacing, spacing, spacing}};
}

static ost_tool *upload(lab *l, ost_tool_volume *volume)
{
    ost_tool *tool = NULL;
    l->status = ost_tool_upload(l->backend, volume, &tool, l->err);
    ost_tool_volume_free(volume);
    return tool;
}

ost_tool *lab_tool(lab *l, ost_dims dims, ost_pm voxel, ost_pm3 corner, uint8_t tool_class)
{
    ost_tool_volume volume;
    if (l->status == OST_OK)
        l->status = ost_tool_volume_init(&volume, &(ost_tool_geometry){dims, voxel, corner}, l->err);
    if (l->status != OST_OK)
        return NULL;
    memset(volume.voxels, tool_class, (size_t)ost_dims_count(dims));
    return upload(l, &volume);
}

ost_tool *lab_random_tool(lab *l, draw *d, ost_dims dims, ost_pm voxel, ost_pm3 corner)
{
    ost_tool_volume volume;
    if (l->status == OST_OK)
        l->status = ost_tool_volume_init(&volume, &(ost_tool_geometry){dims, voxel, corner}, l->err);
    if (l->status != OST_OK)
        return NULL;
    for (int64_t i = 0; i < ost_dims_count(dims); i++)
        volume.voxels[i] = draw_one_in(d, 4)   ? OST_TOOL_VOID
                           : draw_one_in(d, 5) ? OST_TOOL_NONCUTTING
                                               : OST_TOOL_CUTTING;
    return upload(l, &volume);
}

ost_pose lab_random_pose(lab *l, draw *d, ost_pm size)
{
    ost_pose pose = ost_pose_identity();
    double q[4], n;
    do {
        n = 0;
        for (int a = 0; a < 4; a++) {
            q[a] = draw_real(d, -1, 1);
            n += q[a] * q[a];
        }
    } while (n > 1 || n < 0.01);
    /* Uses Newton's method instead of sqrt, so that no result depends on libm. The length of q is then within 1e-3 of
       1, as ost_pose_from_doubles requires. */
    double root = 1;
    for (int i = 0; i < 30; i++)
        root = 0.5 * (root + n / root);
    for (int a = 0; a < 4; a++)
        q[a] /= root;
    if (l->status == OST_OK)
        l->status = ost_pose_from_doubles((double[3]){0, 0, 0}, q, &pose, l->err);
    pose.t = draw_point(d, 0, size);
    return pose;
}

void lab_fill(draw *d, int16_t *voxels, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        voxels[i] = (int16_t)(draw_one_in(d, 4) ? 0 : draw_between(d, 120, 1000));
}

void lab_remove(lab *l, const ost_geometry *g, int chunk, int16_t *voxels, const ost_tool *tool, const ost_pose *poses,
                int count, ost_removal_report *report)
{
    ost_bone *bone = NULL;
    ost_removal_report own = {0};
    const ost_density_classes classes = ost_density_classes_default();
    ost_map *maps = calloc((size_t)count, sizeof *maps);
    ost_voxel_box *boxes = calloc((size_t)count, sizeof *boxes);
    if (l->status == OST_OK && (!maps || !boxes))
        l->status = ost_fail(l->err, OST_ERR_MEMORY, "out of memory for %d poses", count);
    for (int k = 0; k < count && l->status == OST_OK; k++) {
        l->status = ost_map_make(&poses[k], g, ost_tool_geometry_get(tool), &maps[k], l->err);
        boxes[k] = (ost_voxel_box){.hi = {g->dims.x, g->dims.y, g->dims.z}};
    }
    const ost_removal_event event = {.pose_count = count, .maps = maps, .boxes = boxes, .classes = &classes};
    if (l->status == OST_OK)
        l->status = ost_bone_create(l->backend, g, chunk, 120, &bone, l->err);
    if (l->status == OST_OK)
        l->status = ost_bone_upload(bone, 0, g->dims.z, voxels, l->err);
    if (l->status == OST_OK)
        l->status = ost_bone_remove(bone, tool, &event, report ? report : &own, l->err);
    if (l->status == OST_OK)
        l->status = ost_bone_download(bone, 0, g->dims.z, voxels, l->err);
    ost_bone_free(bone);
    ost_removal_report_free(&own);
    free(boxes);
    free(maps);
}

uint64_t lab_removed(lab *l, const ost_geometry *g, const ost_tool *tool, const ost_pose *poses, int count,
                     int16_t density)
{
    const int64_t all = ost_dims_count(g->dims);
    uint64_t gone = 0;
    int16_t *voxels = malloc((size_t)all * sizeof *voxels);
    if (l->status == OST_OK && !voxels)
        l->status = ost_fail(l->err, OST_ERR_MEMORY, "out of memory for a bone");
    for (int64_t i = 0; voxels && i < all; i++)
        voxels[i] = density;
    if (voxels)
        lab_remove(l, g, 32, voxels, tool, poses, count, NULL);
    for (int64_t i = 0; voxels && i < all; i++)
        gone += voxels[i] == 0;
    free(voxels);
    return gone;
}

void lab_box(lab *l, ost_pm3 min, ost_pm3 max, bool inside_out, ost_mesh *out)
{
    /* The 8 vertices are numbered by their position: bit a is set if the vertex is at the box's maximum on axis a. */
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    *out = (ost_mesh){.vertex_count = 0};
    if (l->status == OST_OK)
        l->status = ost_mesh_init(out, 8, 12, l->err);
    if (l->status != OST_OK)
        return;
    for (uint32_t v = 0; v < 8; v++)
        out->vertices[v] = (ost_pm3){v & 1 ? max.x : min.x, v & 2 ? max.y : min.y, v & 4 ? max.z : min.z};
    for (size_t t = 0; t < 12; t++)
        for (int k = 0; k < 3; k++)
            out->triangles[t][k] = faces[t][inside_out ? 2 - k : k];
}

void lab_voxelize(lab *l, const ost_mesh *mesh, const ost_tool_geometry *grid, ost_pm voxel, ost_tool_volume *out)
{
    ost_tool_geometry own;
    ost_snapped_mesh snapped = {.vertex_count = 0};
    ost_voxelize_report report;
    ost_tool *tool = NULL;
    ost_pm3 min, max;
    *out = (ost_tool_volume){.voxels = NULL};
    if (l->status == OST_OK)
        l->status = ost_mesh_bounds(mesh, &min, &max, l->err);
    if (l->status == OST_OK && !grid)
        l->status = ost_tool_geometry_from_bounds(min, max, voxel, &own, l->err);
    if (l->status == OST_OK)
        l->status = ost_mesh_snap(mesh, grid ? grid : &own, &snapped, l->err);
    if (l->status == OST_OK)
        l->status = ost_voxelize(l->backend, &snapped, NULL, OST_FILL_WINDING, &report, &tool, l->err);
    if (l->status == OST_OK)
        l->status = ost_tool_download(tool, out, l->err);
    ost_tool_free(tool);
    ost_snapped_mesh_free(&snapped);
}
