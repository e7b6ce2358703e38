/* SPDX-License-Identifier: Apache-2.0 */
#include "io/mesh/write_obj.h"

#include <osteon/length.h>

#include "core/conditions.h"
#include "io/outfile.h"

static ost_status write_body(ost_outfile *out, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
{
    ost_status status = ost_outfile_printf(out, err, "# millimetres, %swritten by osteon\n",
                                           frame == OST_MESH_LPS ? OST_MESH_SPACE_LPS ", " : "");
    for (size_t v = 0; v < mesh->vertex_count && status == OST_OK; v++) {
        const ost_pm3 *p = &mesh->vertices[v];
        char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
        status = ost_outfile_printf(out, err, "v %s %s %s\n", ost_pm_format(p->x, x), ost_pm_format(p->y, y),
                                    ost_pm_format(p->z, z));
    }
    for (size_t t = 0; t < mesh->triangle_count && status == OST_OK; t++) {
        const uint32_t *c = mesh->triangles[t]; /* OBJ files number vertices from 1, so 1 is added to each index */
        status = ost_outfile_printf(out, err, "f %zu %zu %zu\n", (size_t)c[0] + 1, (size_t)c[1] + 1, (size_t)c[2] + 1);
    }
    return status;
}

ost_status ost_mesh_write_obj(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
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
