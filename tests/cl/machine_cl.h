/* SPDX-License-Identifier: Apache-2.0 */
/* A machine (machine.h) that is an OpenCL device. */
#ifndef OST_TESTS_CL_MACHINE_CL_H
#define OST_TESTS_CL_MACHINE_CL_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "cl/machine.h"

/* group: items of a work group along the first dimension; 0 lets the device choose. */
machine *machine_on(cl_device_id device, int rows, size_t group);
void machine_off(machine *m);

/* Builds the given files of src/cl/kernels, in this order, as one program; on failure the test fails with the build
   log. */
cl_program program_of(cl_context context, cl_device_id device, const char *const *names, unsigned count,
                      const char *options);

#endif
