/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Snaps vertices in picometres to the lattice on which voxelization is exact (AR-MESH-3, AR-MESH-4).
 *
 *   v = RHE((p - corner) * 2^f / s),   0 <= v <= dims * 2^f <= 2^20
 *
 * Here p is a coordinate of a vertex, s is the voxel size, and f is the number of fraction bits: 10 if
 * the longest axis has up to 1024 voxels, 9 up to 2048, and 8 up to 4096 (the limit of a tool).  As
 * f > 0, the centre of a voxel, (i + 1/2) 2^f, is always a lattice point.
 *
 * Triangles whose snapped cross product is zero have no area and no effect; they
 * are dropped and counted.  The order of the other triangles does not change.  The
 * number of vertices does not change; a vertex that no triangle uses is set to 0 0 0.
 *
 * Ranges: p - corner <= 1.6e13 < 2^44 and 2^f <= 2^10, so the numerator is below
 * 2^54.  Components of edges are below 2^20 + 1, their products below 2^41, and
 * differences of two products below 2^42.
 */
#include <osteon/tool.h>

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

static int32_t widest(ost_dims dims)
{
    int32_t w = dims.x > dims.y ? dims.x : dims.y;
    return w > dims.z ? w : dims.z;
}

static int fraction_bits(ost_dims dims)
{
    int f = 10;
    while ((int64_t)widest(dims) << f > 1 << 20)
        f--;
    return f;
}

/*
 * Snaps one coordinate. Returns false if p is outside the box of the grid. |p| and |corner| are bounded,
 * so there is no overflow.
 */
static bool snap(ost_pm p, ost_pm corner, ost_pm voxel, int32_t dim, int f, int32_t *out)
{
    if (p < -OST_LENGTH_MAX || p > OST_LENGTH_MAX || p < corner || p - corner > dim * voxel)
        return false;
    *out = (int32_t)ost_rhe_div((p - corner) << f, voxel);
    return true;
}

static bool snap3(const ost_pm3 *p, const ost_tool_geometry *g, int f, int32_t v[3])
{
    return snap(p->x, g->corner.x, g->voxel, g->dims.x, f, &v[0]) &&
           snap(p->y, g->corner.y, g->voxel, g->dims.y, f, &v[1]) &&
           snap(p->z, g->corner.z, g->voxel, g->dims.z, f, &v[2]);
}

static bool has_area(const int32_t a[3], const int32_t b[3], const int32_t c[3])
{
    int64_t u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (int64_t)b[i] - a[i];
        v[i] = (int64_t)c[i] - a[i];
    }
    return u[1] * v[2] != u[2] * v[1] || u[2] * v[0] != u[0] * v[2] || u[0] * v[1] != u[1] * v[0];
}

/*
 * Snaps the vertices of all triangles. A vertex is snapped for each triangle that uses it, which is faster than
 * recording which vertices are already snapped.
 */
static ost_status snap_vertices(const ost_mesh *mesh, ost_snapped_mesh *out, ost_error *err)
{
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            uint32_t i = mesh->triangles[t][c];
            if (i >= mesh->vertex_count)
                return ost_fail(err, OST_ERR_USAGE, "mesh: triangle %zu uses vertex %u of %zu", t, (unsigned)i,
                                mesh->vertex_count);
            const ost_pm3 *p = &mesh->vertices[i];
            if (!snap3(p, &out->grid, out->fraction_bits, out->vertices[i])) {
                char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
                return ost_fail(err, OST_ERR_RANGE, "mesh: vertex %u (%s %s %s mm) lies outside the tool grid",
                                (unsigned)i, ost_pm_format(p->x, x), ost_pm_format(p->y, y), ost_pm_format(p->z, z));
            }
        }
    return OST_OK;
}

static void store_area(const ost_mesh *mesh, ost_snapped_mesh *out)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->triangles[t];
        if (has_area(out->vertices[v[0]], out->vertices[v[1]], out->vertices[v[2]]))
            memcpy(out->triangles[out->triangle_count++], v, sizeof out->triangles[0]);
        else
            out->dropped_triangles++;
    }
}

ost_status ost_mesh_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    ost_status status = ost_tool_geometry_check(grid, err);
    if (status != OST_OK)
        return status;
    if (mesh->triangle_count > OST_MESH_TRIANGLES_MAX || mesh->vertex_count > 3 * (size_t)OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "mesh: %zu triangles, %zu vertices; at most %d triangles",
                        mesh->triangle_count, mesh->vertex_count, OST_MESH_TRIANGLES_MAX);
    out->grid = *grid;
    out->fraction_bits = fraction_bits(grid->dims);
    out->vertex_count = mesh->vertex_count;
    assert(out->fraction_bits >= 8);

    /* There are at most 3 * 2^26 elements of 12 bytes. One more element is allocated, so that the size is never 0. */
    out->vertices = calloc(mesh->vertex_count + 1, sizeof *out->vertices);
    out->triangles = malloc((mesh->triangle_count + 1) * sizeof *out->triangles);
    if (!out->vertices || !out->triangles)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory to snap a mesh of %zu triangles", mesh->triangle_count);
    else
        status = snap_vertices(mesh, out, err);
    if (status == OST_OK)
        store_area(mesh, out);
    else
        ost_snapped_mesh_free(out);
    return status;
}

void ost_snapped_mesh_free(ost_snapped_mesh *mesh)
{
    free(mesh->vertices);
    free(mesh->triangles);
    memset(mesh, 0, sizeof *mesh);
}

/*
 * The input of the digest (AR-DIG-7): a header of 84 bytes, then every vertex as three
 * int32, then every triangle as three uint32.  All numbers are little-endian, in the byte
 * order of the machine (core/conditions.h).
 *
 *     0  "OSTEONM1"            24  int64 voxel         60  uint64 vertices
 *     8  uint32 arithmetic     32  int64 corner x y z  68  uint64 triangles
 *    12  int32 dims x y z      56  int32 f             76  uint64 dropped
 */
enum { DIGEST_HEADER = 84 };

static uint8_t *put(uint8_t *at, uint64_t value, size_t bytes)
{
    memcpy(at, &value, bytes);
    return at + bytes;
}

static void digest_header(const ost_snapped_mesh *mesh, uint8_t header[DIGEST_HEADER])
{
    const ost_tool_geometry *g = &mesh->grid;
    memcpy(header, "OSTEONM1", 8);
    uint8_t *at = put(header + 8, OST_ARITHMETIC_VERSION, 4);
    at = put(at, (uint64_t)g->dims.x, 4);
    at = put(at, (uint64_t)g->dims.y, 4);
    at = put(at, (uint64_t)g->dims.z, 4);
    at = put(at, (uint64_t)g->voxel, 8);
    at = put(at, (uint64_t)g->corner.x, 8);
    at = put(at, (uint64_t)g->corner.y, 8);
    at = put(at, (uint64_t)g->corner.z, 8);
    at = put(at, (uint64_t)mesh->fraction_bits, 4);
    at = put(at, mesh->vertex_count, 8);
    at = put(at, mesh->triangle_count, 8);
    at = put(at, mesh->dropped_triangles, 8);
    assert(at == header + DIGEST_HEADER);
    (void)at;
}

ost_status ost_snapped_mesh_digest(const ost_snapped_mesh *mesh, ost_digest *out, ost_error *err)
{
    uint8_t header[DIGEST_HEADER];
    ost_hasher *hasher;
    ost_status status = ost_hasher_open(&hasher, err);
    if (status != OST_OK)
        return status;
    digest_header(mesh, header);
    status = ost_hasher_add(hasher, header, sizeof header, err);
    if (status == OST_OK)
        status = ost_hasher_add(hasher, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices, err);
    if (status == OST_OK)
        status = ost_hasher_add(hasher, mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles, err);
    if (status == OST_OK)
        return ost_hasher_close(hasher, out, err);
    ost_hasher_close(hasher, NULL, NULL);
    return status;
}
