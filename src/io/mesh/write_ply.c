/* SPDX-License-Identifier: Apache-2.0 */
#include "io/mesh/write_ply.h"

#include <string.h>

#include "core/conditions.h"
#include "io/outfile.h"

static ost_status write_body(ost_outfile *out, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
{
    ost_status status = ost_outfile_printf(
        out, err,
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\n%selement vertex %zu\n"
        "property float x\nproperty float y\nproperty float z\nelement face %zu\n"
        "property list uchar int vertex_indices\nend_header\n",
        frame == OST_MESH_LPS ? "comment " OST_MESH_SPACE_LPS "\n" : "", mesh->vertex_count, mesh->triangle_count);
    for (size_t v = 0; v < mesh->vertex_count && status == OST_OK; v++) {
        const float p[3] = {(float)ost_pm_to_mm(mesh->vertices[v].x), (float)ost_pm_to_mm(mesh->vertices[v].y),
                            (float)ost_pm_to_mm(mesh->vertices[v].z)};
        status = ost_outfile_write(out, p, sizeof p, err);
    }
    for (size_t t = 0; t < mesh->triangle_count && status == OST_OK; t++) {
        unsigned char face[13] = {3};
        memcpy(face + 1, mesh->triangles[t], 12);
        status = ost_outfile_write(out, face, sizeof face, err);
    }
    return status;
}

ost_status ost_mesh_write_ply(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
{
    ost_outfile *out = NULL;
    ost_status status = ost_outfile_open(path, &out, err);
    if (status != OST_OK)
        return status;
    status = write_body(out, mesh, frame, err);
    if (status == OST_OK)
        return ost_outfile_commit(out, err);
    ost_outfile_discard(out);
    return status;
}
