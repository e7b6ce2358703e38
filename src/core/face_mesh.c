/* SPDX-License-Identifier: Apache-2.0 */
/* Manages the memory of face meshes, and calls the backend's `face_mesh` slot. */
#include "core/backend.h"

#include <stdlib.h>
#include <string.h>

void ost_face_mesh_free(ost_face_mesh *mesh)
{
    free(mesh->first);
    free(mesh->vertices);
    *mesh = (ost_face_mesh){0};
}

/* Returns a capacity of at least `need`, about 1.5 times the current one, so that few calls reallocate. */
static size_t larger(size_t capacity, size_t need)
{
    const size_t more = capacity + capacity / 2 + 256;
    return more > need ? more : need;
}

ost_status ost_face_mesh_reserve(ost_face_mesh *mesh, size_t chunks, size_t quads, ost_error *err)
{
    if (chunks >= mesh->chunk_capacity) {
        const size_t capacity = larger(mesh->chunk_capacity, chunks + 1);
        uint32_t *first = realloc(mesh->first, capacity * sizeof *first);
        if (!first)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the meshes of %zu chunks", chunks);
        mesh->first = first;
        mesh->chunk_capacity = capacity;
    }
    if (quads > mesh->quad_capacity) {
        /*
         * The index of a vertex has 32 bits, and the size of the vertices in bytes must also be addressable by OpenGL.
         * A quad has 4 vertices of 4 bytes.
         */
        const size_t capacity = larger(mesh->quad_capacity, quads);
        if (quads > UINT32_MAX / 8)
            return ost_fail(err, OST_ERR_RANGE, "a mesh of %zu faces; expected at most %u", quads, UINT32_MAX / 8);
        uint32_t *vertices = realloc(mesh->vertices, capacity * 4 * sizeof *vertices);
        if (!vertices)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a mesh of %zu faces", quads);
        mesh->vertices = vertices;
        mesh->quad_capacity = capacity;
    }
    return OST_OK;
}

ost_status ost_backend_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count,
                                 ost_face_mesh *mesh, ost_error *err)
{
    if (!backend || !mesh || (count > 0 && !clusters) || count > OST_FACE_CLUSTERS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a mesh needs a backend and at most %d chunks", OST_FACE_CLUSTERS_MAX);
    if (!backend->ops->face_mesh)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "backend %s makes no meshes; use cpu, ref or cl", backend->ops->name);
    mesh->count = count;
    memset(mesh->stage_ns, 0, sizeof mesh->stage_ns);
    ost_status status = ost_face_mesh_reserve(mesh, count, 1, err);
    if (status != OST_OK)
        return status;
    mesh->first[0] = 0;
    return count ? backend->ops->face_mesh(backend, clusters, count, mesh, err) : OST_OK;
}
