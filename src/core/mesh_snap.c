/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From picometres to the lattice on which voxelization is exact (AR-MESH).
 *
 *   v = RHE((p - corner) * 2^f / s),   0 <= v <= dims * 2^f <= 2^20
 *
 * f is the greatest fraction of at most 10 bits that keeps the widest axis
 * within 2^20: 10 up to 1024 voxels, 9 up to 2048, 8 up to 4096 (the limit of
 * a tool), so a voxel's centre, (i + 1/2) 2^f, is always a lattice point.
 *
 * Triangles whose snapped cross product is zero have no area left; they can
 * decide nothing, are dropped, and are counted.  Vertices that no remaining
 * triangle uses are left out; the others keep their order.
 *
 * Ranges: p - corner <= 1.6e13 < 2^44 and 2^f <= 2^10, so the
 * numerator stays under 2^54.  Edges are below 2^20 + 1, their products below
 * 2^41, a difference of two below 2^42.
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

/* False when p lies outside the grid's box; |p| and |corner| are bounded first, so nothing overflows. */
static bool snap(ost_pm p, ost_pm corner, ost_pm voxel, int32_t dim, int f, int32_t *out)
{
    if (p < -OST_LENGTH_MAX || p > OST_LENGTH_MAX || p < corner || p - corner > dim * voxel)
        return false;
    *out = (int32_t)ost_rhe_div((p - corner) << f, voxel);
    return true;
}

static bool snap3(const ost_pm3 *p, const ost_tool_geometry *g, int f, int32_t v[3])
{
    return snap(p->x, g->corner.x, g->voxel, g->dims.x, f, &v[0]) && snap(p->y, g->corner.y, g->voxel, g->dims.y, f, &v[1]) &&
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

/* Snaps the vertices that triangles use, into all[]; the index of the first bad one is an error. */
static ost_status snap_vertices(const ost_mesh *mesh, const ost_tool_geometry *grid, int f, int32_t (*all)[3], ost_error *err)
{
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            uint32_t i = mesh->triangles[t][c];
            if (i >= mesh->vertex_count)
                return ost_fail(err, OST_ERR_USAGE, "mesh: triangle %zu uses vertex %u of %zu", t, (unsigned)i, mesh->vertex_count);
            const ost_pm3 *p = &mesh->vertices[i];
            if (!snap3(p, grid, f, all[i])) {
                char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
                return ost_fail(err, OST_ERR_RANGE, "mesh: vertex %u (%s %s %s mm) lies outside the tool grid", (unsigned)i,
                                ost_pm_format(p->x, x), ost_pm_format(p->y, y), ost_pm_format(p->z, z));
            }
        }
    return OST_OK;
}

/* Copies the triangles with area, and numbers the vertices they use in their first order. */
static void keep_area(const ost_mesh *mesh, int32_t (*const all)[3], uint32_t *renumber, ost_snapped_mesh *out)
{
    memset(renumber, 0xff, mesh->vertex_count * sizeof *renumber);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->triangles[t];
        if (!has_area(all[v[0]], all[v[1]], all[v[2]])) {
            out->dropped_triangles++;
            continue;
        }
        for (int c = 0; c < 3; c++)
            renumber[v[c]] = 0;
        memcpy(out->triangles[out->triangle_count++], v, sizeof out->triangles[0]);
    }
    for (size_t i = 0; i < mesh->vertex_count; i++)
        if (renumber[i] != UINT32_MAX) {
            renumber[i] = (uint32_t)out->vertex_count;
            memcpy(out->vertices[out->vertex_count++], all[i], sizeof all[i]);
        }
    for (size_t t = 0; t < out->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            out->triangles[t][c] = renumber[out->triangles[t][c]];
}

ost_status ost_mesh_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    ost_status status = ost_tool_geometry_check(grid, err);
    if (status != OST_OK)
        return status;
    if (mesh->triangle_count > OST_MESH_TRIANGLES_MAX || mesh->vertex_count > 3 * (size_t)OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "mesh: %zu triangles, %zu vertices; at most %d triangles", mesh->triangle_count,
                        mesh->vertex_count, OST_MESH_TRIANGLES_MAX);
    out->grid = *grid;
    out->fraction_bits = fraction_bits(grid->dims);
    assert(out->fraction_bits >= 8);

    /* Sizes were bounded above: at most 3 * 2^26 elements of 12 bytes. One more each, so that none is of size 0. */
    int32_t(*all)[3] = malloc((mesh->vertex_count + 1) * sizeof *all);
    uint32_t *renumber = malloc((mesh->vertex_count + 1) * sizeof *renumber);
    out->vertices = malloc((mesh->vertex_count + 1) * sizeof *out->vertices);
    out->triangles = malloc((mesh->triangle_count + 1) * sizeof *out->triangles);
    if (!all || !renumber || !out->vertices || !out->triangles)
        status = ost_fail(err, OST_ERR_MEMORY, "no memory to snap a mesh of %zu triangles", mesh->triangle_count);
    else
        status = snap_vertices(mesh, grid, out->fraction_bits, all, err);
    if (status == OST_OK)
        keep_area(mesh, all, renumber, out);
    else
        ost_snapped_mesh_free(out);
    free(renumber);
    free(all);
    return status;
}

void ost_snapped_mesh_free(ost_snapped_mesh *mesh)
{
    free(mesh->vertices);
    free(mesh->triangles);
    memset(mesh, 0, sizeof *mesh);
}

static void put32(uint8_t *at, uint32_t value)
{
    memcpy(at, &value, sizeof value); /* little-endian: core/conditions.h */
}

static void put64(uint8_t *at, uint64_t value)
{
    memcpy(at, &value, sizeof value);
}

/*
 * AR-DIG-7: SHA-256 over a header of 128 bytes and a record of nine int32 a
 * triangle, its corners' x y z, in order.  Little-endian.  What counts is the
 * triangles, not how the file shares vertices among them.
 *
 *     0  "OSTEONM1"            16  int32 dims x y z       64  uint64 triangles
 *     8  uint32 arithmetic     32  int64 voxel            72  zero
 *    12  uint32 fraction bits  40  int64 corner x y z
 */
static void digest_header(const ost_snapped_mesh *mesh, uint8_t header[128])
{
    memset(header, 0, 128);
    memcpy(header, "OSTEONM1", 8);
    put32(header + 8, OST_ARITHMETIC_VERSION);
    put32(header + 12, (uint32_t)mesh->fraction_bits);
    put32(header + 16, (uint32_t)mesh->grid.dims.x);
    put32(header + 20, (uint32_t)mesh->grid.dims.y);
    put32(header + 24, (uint32_t)mesh->grid.dims.z);
    put64(header + 32, (uint64_t)mesh->grid.voxel);
    put64(header + 40, (uint64_t)mesh->grid.corner.x);
    put64(header + 48, (uint64_t)mesh->grid.corner.y);
    put64(header + 56, (uint64_t)mesh->grid.corner.z);
    put64(header + 64, mesh->triangle_count);
}

ost_status ost_snapped_mesh_digest(const ost_snapped_mesh *mesh, ost_digest *out, ost_error *err)
{
    enum { BATCH = 1024 };
    int32_t records[BATCH][3][3];
    uint8_t header[128];
    ost_hasher *hasher = NULL;
    ost_status status = ost_hasher_open(&hasher, err);
    if (status != OST_OK)
        return status;
    digest_header(mesh, header);
    status = ost_hasher_add(hasher, header, sizeof header, err);
    for (size_t t = 0; status == OST_OK && t < mesh->triangle_count; t += BATCH) {
        size_t n = mesh->triangle_count - t < BATCH ? mesh->triangle_count - t : BATCH;
        for (size_t i = 0; i < n; i++)
            for (int c = 0; c < 3; c++)
                memcpy(records[i][c], mesh->vertices[mesh->triangles[t + i][c]], sizeof records[i][c]);
        status = ost_hasher_add(hasher, records, n * sizeof records[0], err);
    }
    ost_error close_err = {0};
    ost_status closed = ost_hasher_close(hasher, status == OST_OK ? out : NULL, status == OST_OK ? err : &close_err);
    return status != OST_OK ? status : closed;
}
