/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dense/steps.h"

#include <stdlib.h>
#include <string.h>

static ost_pm coordinate(const ost_pm3 *p, int axis)
{
    return axis == 0 ? p->x : axis == 1 ? p->y : p->z;
}

/* Finds the lowest and the highest coordinate along one axis. Only vertices that belong to a triangle of one of the
   meshes are included. */
static bool ends(const ost_mesh meshes[2], int axis, ost_pm *least, ost_pm *most)
{
    bool any = false;
    for (int m = 0; m < 2; m++)
        for (size_t t = 0; t < meshes[m].triangle_count; t++)
            for (int c = 0; c < 3; c++) {
                if (meshes[m].triangles[t][c] >= meshes[m].vertex_count)
                    return false;
                const ost_pm v = coordinate(&meshes[m].vertices[meshes[m].triangles[t][c]], axis);
                *least = any && *least < v ? *least : v;
                *most = any && *most > v ? *most : v;
                any = true;
            }
    return any;
}

bool steps_tool_grid(const ost_mesh meshes[2], ost_pm voxel, ost_tool_geometry *out)
{
    const int64_t metres_8 = 8000000000000;
    ost_pm corner[3];
    int32_t dims[3];
    wide all = wide_of(1);
    for (int a = 0; a < 3; a++) {
        ost_pm least = 0, most = 0;
        if (voxel < 1000000 || voxel > 100000000000 || !ends(meshes, a, &least, &most))
            return false;
        /* The ends of the grid, in voxels, are RHE(least / s - 1/2) - 1 and RHE(most / s + 1/2) + 1. RHE rounds half
           to even. */
        const wide s = wide_of(voxel), two_s = wide_of(2 * voxel);
        const wide near = wide_minus(wide_nearest(wide_minus(wide_of(2 * least), s), two_s), wide_of(1));
        const wide far = wide_plus(wide_nearest(wide_plus(wide_of(2 * most), s), two_s), wide_of(1));
        const int64_t n = wide_to_int64(wide_minus(far, near));
        corner[a] = wide_to_int64(wide_times(near, s));
        if (n > 4096 || corner[a] < -metres_8 || wide_order(wide_times(far, s), wide_of(metres_8)) > 0)
            return false;
        dims[a] = (int32_t)n;
        all = wide_times(all, wide_of(n));
    }
    *out = (ost_tool_geometry){{dims[0], dims[1], dims[2]}, voxel, {corner[0], corner[1], corner[2]}};
    return wide_order(all, wide_power_of_two(33)) <= 0;
}

/* Returns the greatest f <= 10 with max(dims) * 2^f <= 2^20. Tests the values from 0 upwards. */
static int fraction_bits(const ost_tool_geometry *grid)
{
    int f = 0;
    while (f < 10 && grid->dims.x <= 1 << (20 - f - 1) && grid->dims.y <= 1 << (20 - f - 1) &&
           grid->dims.z <= 1 << (20 - f - 1))
        f++;
    return f;
}

/* Returns true if the area of the triangle is not 0. Because |u|^2 * |v|^2 - (u . v)^2 = |u x v|^2, the left side is 0
   if and only if the cross product is 0. */
static bool has_area(const int32_t a[3], const int32_t b[3], const int32_t c[3])
{
    wide uu = wide_of(0), vv = uu, uv = uu;
    for (int i = 0; i < 3; i++) {
        const wide u = wide_of((int64_t)b[i] - a[i]), v = wide_of((int64_t)c[i] - a[i]);
        uu = wide_plus(uu, wide_times(u, u));
        vv = wide_plus(vv, wide_times(v, v));
        uv = wide_plus(uv, wide_times(u, v));
    }
    return wide_order(wide_times(uu, vv), wide_times(uv, uv)) != 0;
}

static ost_status snap_vertex(const ost_pm3 *p, const ost_tool_geometry *grid, int f, int32_t out[3], ost_error *err)
{
    const int32_t dims[3] = {grid->dims.x, grid->dims.y, grid->dims.z};
    for (int a = 0; a < 3; a++) {
        const wide way = wide_minus(wide_of(coordinate(p, a)), wide_of(coordinate(&grid->corner, a)));
        if (way.negative || wide_order(way, wide_times(wide_of(dims[a]), wide_of(grid->voxel))) > 0)
            return ost_fail(err, OST_ERR_RANGE, "a vertex of a mesh lies outside the tool grid (AR-MESH-3)");
        out[a] = (int32_t)wide_to_int64(wide_nearest(wide_times(way, wide_power_of_two(f)), wide_of(grid->voxel)));
    }
    return OST_OK;
}

ost_status steps_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err)
{
    *out = (ost_snapped_mesh){.grid = *grid, .fraction_bits = fraction_bits(grid), .vertex_count = mesh->vertex_count};
    out->vertices = calloc(mesh->vertex_count + 1, sizeof *out->vertices);
    out->triangles = calloc(mesh->triangle_count + 1, sizeof *out->triangles);
    bool *used = calloc(mesh->vertex_count + 1, sizeof *used);
    ost_status status = OST_OK;
    if (!out->vertices || !out->triangles || !used)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory to snap a mesh of %zu triangles", mesh->triangle_count);
    for (size_t t = 0; t < mesh->triangle_count && status == OST_OK; t++)
        for (int c = 0; c < 3 && status == OST_OK; c++) {
            if (mesh->triangles[t][c] >= mesh->vertex_count)
                status = ost_fail(err, OST_ERR_USAGE, "mesh: triangle %zu uses a vertex beyond the last", t);
            else
                used[mesh->triangles[t][c]] = true;
        }
    for (size_t v = 0; v < mesh->vertex_count && status == OST_OK; v++)
        if (used[v])
            status = snap_vertex(&mesh->vertices[v], grid, out->fraction_bits, out->vertices[v], err);
    for (size_t t = 0; t < mesh->triangle_count && status == OST_OK; t++) {
        const uint32_t *v = mesh->triangles[t];
        if (has_area(out->vertices[v[0]], out->vertices[v[1]], out->vertices[v[2]]))
            memcpy(out->triangles[out->triangle_count++], v, sizeof out->triangles[0]);
        else
            out->dropped_triangles++;
    }
    free(used);
    if (status != OST_OK)
        ost_snapped_mesh_free(out);
    return status;
}
