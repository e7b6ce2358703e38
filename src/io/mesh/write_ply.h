/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_MESH_WRITE_PLY_H
#define OST_IO_MESH_WRITE_PLY_H

#include <osteon/mesh.h>

#include "io/mesh/frame.h"

/* Writes a binary little-endian PLY file. Vertices are float32, in millimetres. */
ost_status ost_mesh_write_ply(const char *path, const ost_mesh *mesh, ost_mesh_frame frame, ost_error *err);

#endif
