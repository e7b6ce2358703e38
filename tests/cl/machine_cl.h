/* SPDX-License-Identifier: Apache-2.0 */
/* Makes machines (machine.h) that run the kernels on an OpenCL device. */
#ifndef OST_TESTS_CL_MACHINE_CL_H
#define OST_TESTS_CL_MACHINE_CL_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "cl/machine.h"

/* Makes a machine on the device. The parameter group is the work-group size in the first dimension, or 0 if the
   device chooses the size. */
machine *machine_on(cl_device_id device, int rows, size_t group);
void machine_off(machine *m);

/* Builds the given files of src/cl/kernels, in this order, as one program. If the build fails, the test fails and
   prints the build log. */
cl_program program_of(cl_context context, cl_device_id device, const char *const *names, unsigned count,
                      const char *options);

#endif
