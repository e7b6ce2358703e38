/* SPDX-License-Identifier: Apache-2.0 */
#include "io/mesh/write_any.h"

#include <string.h>
#include <strings.h>

#include "io/mesh/write_obj.h"
#include "io/mesh/write_ply.h"

ost_status ost_mesh_write_any(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err)
{
    const char *end = strrchr(path, '.');
    if (end && strcasecmp(end, ".ply") == 0)
        return ost_mesh_write_ply(path, mesh, frame, err);
    if (end && strcasecmp(end, ".obj") == 0)
        return ost_mesh_write_obj(path, mesh, frame, err);
    return ost_mesh_write_stl_framed(path, mesh, frame, err);
}
