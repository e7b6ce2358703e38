/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes binary STL, little-endian: a header of 80 bytes, a uint32 count, and for
 * each triangle its normal, three corners (float32, millimetres) and a uint16 of 0.
 *
 * A corner is the position in millimetres, rounded to the nearest double and then
 * to the nearest float32. Normals are written only for viewers. Equal meshes give
 * equal files, because the header contains the program's name but neither a date nor
 * the name of a machine.
 */
#include <math.h>
#include <string.h>

#include "core/conditions.h"
#include "io/outfile.h"

#include "io/mesh/write_any.h"

#include <osteon/io.h>

static void normal(const float v[3][3], float n[3])
{
    double u[3], w[3], c[3];
    for (int a = 0; a < 3; a++) {
        u[a] = (double)v[1][a] - (double)v[0][a];
        w[a] = (double)v[2][a] - (double)v[0][a];
    }
    for (int a = 0; a < 3; a++)
        c[a] = u[(a + 1) % 3] * w[(a + 2) % 3] - u[(a + 2) % 3] * w[(a + 1) % 3];
    double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    for (int a = 0; a < 3; a++)
        n[a] = length > 0 ? (float)(c[a] / length) : 0.0f;
}

static ost_status write_triangle(ost_outfile *file, const ost_mesh *mesh, const uint32_t t[3], ost_error *err)
{
    uint8_t record[50] = {0};
    float v[3][3], n[3];
    for (int c = 0; c < 3; c++) {
        const ost_pm3 *p = &mesh->vertices[t[c]];
        v[c][0] = (float)ost_pm_to_mm(p->x);
        v[c][1] = (float)ost_pm_to_mm(p->y);
        v[c][2] = (float)ost_pm_to_mm(p->z);
    }
    normal((const float(*)[3])v, n);
    memcpy(record, n, sizeof n);
    memcpy(record + 12, v, sizeof v);
    return ost_outfile_write(file, record, sizeof record, err);
}

ost_status ost_mesh_write_stl_framed(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
{
    char header[84] = "binary STL, millimetres, written by osteon";
    if (frame == OST_MESH_LPS)
        strcpy(header, "binary STL, millimetres, " OST_MESH_SPACE_LPS ", written by osteon");
    if (mesh->triangle_count > OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %zu triangles; at most %d", path, mesh->triangle_count,
                        OST_MESH_TRIANGLES_MAX);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            if (mesh->triangles[t][c] >= mesh->vertex_count)
                return ost_fail(err, OST_ERR_USAGE, "%s: triangle %zu uses vertex %u of %zu", path, t,
                                (unsigned)mesh->triangles[t][c], mesh->vertex_count);
    uint32_t count = (uint32_t)mesh->triangle_count;
    memcpy(header + 80, &count, sizeof count);

    ost_outfile *file;
    ost_status status = ost_outfile_open(path, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_write(file, header, sizeof header, err);
    for (size_t t = 0; status == OST_OK && t < mesh->triangle_count; t++)
        status = write_triangle(file, mesh, mesh->triangles[t], err);
    if (status == OST_OK)
        return ost_outfile_commit(file, err);
    ost_outfile_discard(file);
    return status;
}

ost_status ost_mesh_write_stl(const char *path, const ost_mesh *mesh, ost_error *err)
{
    return ost_mesh_write_stl_framed(path, mesh, OST_MESH_OWN, err);
}
