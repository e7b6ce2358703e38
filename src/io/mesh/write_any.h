/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_MESH_WRITE_ANY_H
#define OST_IO_MESH_WRITE_ANY_H

#include <osteon/mesh.h>

#include "io/mesh/frame.h"

/* Writes a mesh in the format of the name's ending, without regard to case: .ply, .obj, otherwise binary STL. */
ost_status ost_mesh_write_any(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

/* Writes a binary STL as ost_mesh_write_stl does, whose header also states the frame if it is LPS. */
ost_status ost_mesh_write_stl_framed(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

#endif
