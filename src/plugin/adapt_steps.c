/* SPDX-License-Identifier: Apache-2.0 */
/* The steps that precede the processing of voxels. If a plugin implements one of these steps, its function is
   called. */
#include "plugin/adapt.h"

#include <stdlib.h>
#include <string.h>

static ost_status is_handed(const plugin_backend *b, const char *slot, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: has no slot %s; the host does this step", b->name, slot);
}

ost_status ost_adapt_snap(ost_backend *backend, const ost_mesh *mesh, const ost_tool_geometry *grid,
                          ost_snapped_mesh *out, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    *out = (ost_snapped_mesh){.grid = *grid, .vertex_count = mesh->vertex_count};
    if (!b->table.snap)
        return is_handed(b, "snap", err);
    const ost_plugin_tool_geometry g = ost_adapt_tool_geometry(grid);
    const ost_plugin_raw_mesh raw = {.size = sizeof raw,
                                     .vertex_count = mesh->vertex_count,
                                     .triangle_count = mesh->triangle_count,
                                     .vertices_pm = &mesh->vertices[0].x,
                                     .triangles = mesh->triangles[0]};
    out->vertices = calloc(mesh->vertex_count + 1, sizeof *out->vertices);
    out->triangles = calloc(mesh->triangle_count + 1, sizeof *out->triangles);
    ost_plugin_snapped made = {.size = sizeof made};
    plugin_error_sink t;
    ost_status status = OST_OK;
    if (!out->vertices || !out->triangles)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory to snap a mesh of %zu triangles", mesh->triangle_count);
    if (status == OST_OK) {
        made.vertices = out->vertices[0];
        made.triangles = out->triangles[0];
        status = ost_adapt_heard(b, "snap", b->table.snap(b->self, &g, &raw, &made, &adapt_listening(&t)->error), &t,
                                 NULL, err);
    }
    if (status == OST_OK && made.triangle_count > mesh->triangle_count)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: snap kept %llu of %zu triangles", b->name,
                          (unsigned long long)made.triangle_count, mesh->triangle_count);
    out->fraction_bits = made.fraction_bits;
    out->triangle_count = status == OST_OK ? (size_t)made.triangle_count : 0;
    for (size_t k = 0; k < out->triangle_count && status == OST_OK; k++)
        for (int c = 0; c < 3; c++)
            if (out->triangles[k][c] >= mesh->vertex_count)
                status = ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: snap kept a triangle with vertex %u of %zu",
                                  b->name, (unsigned)out->triangles[k][c], mesh->vertex_count);
    out->dropped_triangles = mesh->triangle_count - out->triangle_count;
    if (status != OST_OK)
        ost_snapped_mesh_free(out);
    return status;
}

/* The receiver of the poses and maps that a plugin computes. */
typedef struct pose_sink {
    int count;
    ost_pose *poses;
    ost_map *maps;
} pose_sink;

static int32_t add_pose(void *user, const ost_plugin_pose *pose, const ost_plugin_map *map)
{
    pose_sink *s = user;
    if (s->count == OST_SWEEP_MAX || !pose || !map)
        return OST_PLUGIN_RANGE;
    ost_map *m = &s->maps[s->count];
    m->divisor = ost_int128_of_plugin(map->divisor);
    for (int a = 0; a < 3; a++) {
        m->origin[a] = ost_int128_of_plugin(map->origin[a]);
        for (int b = 0; b < 3; b++) {
            m->column[b][a] = ost_int128_of_plugin(map->column[b][a]);
            m->step[b][a] = map->step[b][a];
        }
    }
    s->poses[s->count++] =
        (ost_pose){{pose->t_pm[0], pose->t_pm[1], pose->t_pm[2]}, pose->q[0], pose->q[1], pose->q[2], pose->q[3]};
    return OST_PLUGIN_OK;
}

static ost_plugin_pose pose_of(const ost_pose *p)
{
    return (ost_plugin_pose){.size = sizeof(ost_plugin_pose),
                             .t_pm = {p->t.x, p->t.y, p->t.z},
                             .q = {p->qw, p->qx, p->qy, p->qz}};
}

ost_status ost_adapt_steps(ost_backend *backend, const ost_geometry *bone, const ost_tool_geometry *tool,
                           const ost_pose *from, const ost_pose *to, int *count, ost_pose *poses, ost_map *maps,
                           ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    if (!b->table.steps)
        return is_handed(b, "steps", err);
    const ost_plugin_geometry grid = ost_adapt_geometry(bone);
    const ost_plugin_tool_geometry its = ost_adapt_tool_geometry(tool);
    const ost_plugin_pose first = from ? pose_of(from) : (ost_plugin_pose){.size = 0}, last = pose_of(to);
    pose_sink s = {.poses = poses, .maps = maps};
    const ost_plugin_steps in = {.size = sizeof in,
                                 .bone = &grid,
                                 .tool = &its,
                                 .from = from ? &first : NULL,
                                 .to = &last,
                                 .sink = &s,
                                 .add = add_pose};
    plugin_error_sink t;
    const ost_status status =
        ost_adapt_heard(b, "steps", b->table.steps(b->self, &in, &adapt_listening(&t)->error), &t, NULL, err);
    *count = s.count;
    return status;
}
