/* SPDX-License-Identifier: Apache-2.0 */
/* Triangle meshes in picometres. */
#include "core/mesh_check.h"

#include <stdlib.h>

ost_status ost_mesh_init(ost_mesh *mesh, size_t vertex_count, size_t triangle_count, ost_error *err)
{
    *mesh = (ost_mesh){0};
    if (triangle_count > OST_MESH_TRIANGLES_MAX || vertex_count > 3 * (size_t)OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a mesh of %zu triangles and %zu vertices; expected at most %d triangles",
                        triangle_count, vertex_count, OST_MESH_TRIANGLES_MAX);
    mesh->vertices = malloc((vertex_count ? vertex_count : 1) * sizeof *mesh->vertices);
    mesh->triangles = malloc((triangle_count ? triangle_count : 1) * sizeof *mesh->triangles);
    if (!mesh->vertices || !mesh->triangles) {
        ost_mesh_free(mesh);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a mesh of %zu triangles", triangle_count);
    }
    mesh->vertex_count = vertex_count;
    mesh->triangle_count = triangle_count;
    return OST_OK;
}

void ost_mesh_free(ost_mesh *mesh)
{
    if (!mesh)
        return;
    free(mesh->vertices);
    free(mesh->triangles);
    *mesh = (ost_mesh){0};
}

ost_status ost_mesh_check_indices(const ost_mesh *mesh, ost_error *err)
{
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            if (mesh->triangles[t][c] >= mesh->vertex_count)
                return ost_fail(err, OST_ERR_USAGE, "mesh: triangle %zu uses vertex %u of %zu", t,
                                (unsigned)mesh->triangles[t][c], mesh->vertex_count);
    return OST_OK;
}

ost_status ost_mesh_bounds(const ost_mesh *mesh, ost_pm3 *min, ost_pm3 *max, ost_error *err)
{
    if (mesh->triangle_count == 0)
        return ost_fail(err, OST_ERR_INPUT, "the mesh has no triangles");
    ost_status status = ost_mesh_check_indices(mesh, err);
    if (status != OST_OK)
        return status;
    *min = (ost_pm3){INT64_MAX, INT64_MAX, INT64_MAX};
    *max = (ost_pm3){INT64_MIN, INT64_MIN, INT64_MIN};
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            ost_pm3_widen(min, max, mesh->vertices[mesh->triangles[t][c]]);
    return OST_OK;
}
