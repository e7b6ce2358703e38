/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels of src/cl/kernels/face_mesh.cl compiled as C, so that no device is needed and sanitizers check them. */
#ifndef OST_TESTS_RENDER_FACE_MESH_AS_C_H
#define OST_TESTS_RENDER_FACE_MESH_AS_C_H

#include "core/face_mesh.h"

/*
 * Meshes chunks with the kernels. The items of a kernel run one after the other, in an order that depends on the seed.
 * The caller must free the mesh with ost_face_mesh_free.
 */
void face_mesh_as_c(const ost_face_cluster *clusters, uint32_t count, uint64_t seed, ost_face_mesh *mesh);

#endif
