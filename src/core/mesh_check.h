/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_CORE_MESH_CHECK_H
#define OST_CORE_MESH_CHECK_H

#include <osteon/mesh.h>

/* Returns OST_ERR_USAGE and names the triangle in err if the index of a vertex is not below vertex_count. */
ost_status ost_mesh_check_indices(const ost_mesh *mesh, ost_error *err);

#endif
