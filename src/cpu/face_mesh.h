/* SPDX-License-Identifier: Apache-2.0 */
/* The face meshes of the CPU backend (core/face_mesh.h), bit-identical to those of the reference. */
#ifndef OST_CPU_FACE_MESH_H
#define OST_CPU_FACE_MESH_H

#include "cpu/cpu.h"

ost_status ost_cpu_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                             ost_error *err);

#endif
