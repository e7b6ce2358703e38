/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_MESH_WRITE_ANY_H
#define OST_IO_MESH_WRITE_ANY_H

#include <osteon/mesh.h>

#include "io/mesh/frame.h"

/*
 * Writes a mesh. The ending of `path`, ignoring case, selects the format: .ply, .obj, or binary STL for all other
 * endings.
 */
ost_status ost_mesh_write_any(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

/* Writes a binary STL file as ost_mesh_write_stl does. If the frame is LPS, the header also states the frame. */
ost_status ost_mesh_write_stl_framed(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

#endif
