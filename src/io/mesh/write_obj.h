/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_MESH_WRITE_OBJ_H
#define OST_IO_MESH_WRITE_OBJ_H

#include <osteon/mesh.h>

#include "io/mesh/frame.h"

/* Writes an OBJ file that contains only vertices and triangles. Lengths are exact decimals in millimetres. */
ost_status ost_mesh_write_obj(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

#endif
