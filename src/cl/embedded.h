/* SPDX-License-Identifier: Apache-2.0 */
/* The sources of the kernels, embedded in the library by build-aux/source-strings. Each source begins with #line. */
#ifndef OST_CL_EMBEDDED_H
#define OST_CL_EMBEDDED_H

#include <stddef.h>

/* The program that computes voxels. It contains only integer arithmetic. */
extern const char *const ost_cl_program[];
extern const size_t ost_cl_program_count;
/* A program whose results show how the device computes with floats. */
extern const char *const ost_cl_floats[];
extern const size_t ost_cl_floats_count;
/* The program that makes face meshes. The meshes are only drawn and do not affect any voxel. */
extern const char *const ost_cl_face_mesh_source[];
extern const size_t ost_cl_face_mesh_source_count;

#endif
