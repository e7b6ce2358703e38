/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The functions of OpenCL 1.2 that this backend calls, as a table of function pointers.
 *
 * All calls go through the table that was passed when the backend was opened. ost_cl_loader is the table of the
 * system's loader. A test passes a copy of this table in which some functions are replaced by functions that count
 * calls, fail, or return wrong results. Therefore the tests need no special OpenCL driver.
 */
#ifndef OST_CL_API_H
#define OST_CL_API_H

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

/* clang-format off */
#define OST_CL_FUNCTIONS(X) \
    X(clGetPlatformIDs) X(clGetPlatformInfo) X(clGetDeviceIDs) X(clGetDeviceInfo) \
    X(clCreateContext) X(clReleaseContext) X(clCreateCommandQueue) X(clReleaseCommandQueue) \
    X(clCreateProgramWithSource) X(clCreateProgramWithBinary) X(clBuildProgram) X(clGetProgramInfo) \
    X(clGetProgramBuildInfo) X(clReleaseProgram) \
    X(clCreateKernel) X(clReleaseKernel) X(clSetKernelArg) X(clGetKernelWorkGroupInfo) \
    X(clCreateBuffer) X(clReleaseMemObject) \
    X(clEnqueueReadBuffer) X(clEnqueueWriteBuffer) X(clEnqueueCopyBuffer) X(clEnqueueFillBuffer) \
    X(clEnqueueNDRangeKernel) X(clFlush) X(clFinish)
/* clang-format on */

typedef struct ost_cl_api {
#define OST_CL_MEMBER(name) __typeof__(name) *name;
    OST_CL_FUNCTIONS(OST_CL_MEMBER)
#undef OST_CL_MEMBER
} ost_cl_api;

extern const ost_cl_api ost_cl_loader;

#endif
