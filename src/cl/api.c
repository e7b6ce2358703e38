/* SPDX-License-Identifier: Apache-2.0 */
/* A table with the functions of the system's OpenCL loader. Only clCreateCommandQueue is deprecated in versions after
   OpenCL 1.2. */
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include "cl/api.h"

const ost_cl_api ost_cl_loader = {
#define OST_CL_MEMBER(name) .name = name,
    OST_CL_FUNCTIONS(OST_CL_MEMBER)
#undef OST_CL_MEMBER
};
