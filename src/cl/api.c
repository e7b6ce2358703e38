/* SPDX-License-Identifier: Apache-2.0 */
/* The system's loader. clCreateCommandQueue is deprecated after 1.2, and the only one that 1.2 has. */
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include "cl/api.h"

const ost_cl_api ost_cl_loader = {
#define OST_CL_MEMBER(name) .name = name,
    OST_CL_FUNCTIONS(OST_CL_MEMBER)
#undef OST_CL_MEMBER
};
