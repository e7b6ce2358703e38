/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' sources, embedded in the library; each begins with #line. Made by build-aux/source-strings. */
#ifndef OST_CL_EMBEDDED_H
#define OST_CL_EMBEDDED_H

#include <stddef.h>

/* The program that decides voxels; it uses integers only. */
extern const char *const ost_cl_program[];
extern const size_t ost_cl_program_count;
/* The program that describes the device's floating point, for the record. */
extern const char *const ost_cl_floats[];
extern const size_t ost_cl_floats_count;

#endif
