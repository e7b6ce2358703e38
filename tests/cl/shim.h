/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replaces the functions of the OpenCL loader by shims that inject faults. The shims work with any driver.
 * The n-th call of a selected function fails with an error code. If requested, all later calls that use the
 * queue fail as well, as they do after the loss of a device.
 */
#ifndef OST_TESTS_CL_SHIM_H
#define OST_TESTS_CL_SHIM_H

#include "cl/cl.h"

/* clang-format off */
#define SHIM_CALLS(X) \
    X(clGetPlatformIDs, CL_OUT_OF_HOST_MEMORY) X(clGetDeviceIDs, CL_DEVICE_NOT_FOUND) \
    X(clGetDeviceInfo, CL_INVALID_DEVICE) \
    X(clCreateContext, CL_DEVICE_NOT_AVAILABLE) X(clCreateCommandQueue, CL_OUT_OF_RESOURCES) \
    X(clCreateProgramWithSource, CL_OUT_OF_HOST_MEMORY) X(clCreateProgramWithBinary, CL_INVALID_BINARY) \
    X(clBuildProgram, CL_BUILD_PROGRAM_FAILURE) X(clCreateKernel, CL_INVALID_KERNEL_NAME) \
    X(clGetKernelWorkGroupInfo, CL_INVALID_KERNEL) X(clSetKernelArg, CL_INVALID_ARG_VALUE) \
    X(clCreateBuffer, CL_MEM_OBJECT_ALLOCATION_FAILURE) X(clEnqueueReadBuffer, CL_OUT_OF_RESOURCES) \
    X(clEnqueueWriteBuffer, CL_OUT_OF_RESOURCES) X(clEnqueueCopyBuffer, CL_OUT_OF_RESOURCES) \
    X(clEnqueueFillBuffer, CL_OUT_OF_HOST_MEMORY) X(clEnqueueNDRangeKernel, CL_OUT_OF_RESOURCES) \
    X(clFinish, CL_DEVICE_NOT_AVAILABLE)
/* clang-format on */

enum shim_call {
#define SHIM_ENUM(name, code) SHIM_##name,
    SHIM_CALLS(SHIM_ENUM)
#undef SHIM_ENUM
    SHIM_COUNT
};

extern const char *const shim_names[SHIM_COUNT];
extern const ost_cl_api shim;

/* Makes the n-th of the following calls fail: n = 1 is the next call, and n = 0 disables failures. If lost is true,
   all later calls that use the queue also fail. */
void shim_fail(enum shim_call call, int n, bool lost);
/*
 * Works like shim_fail with lost = true, except that only calls that wait report the loss. All other calls
 * return success without any effect.
 */
void shim_fail_late(enum shim_call call, int n);
/* Returns true if the selected call has failed. */
bool shim_failed(void);
/* Kinds of objects that the backend creates. */
enum shim_object { SHIM_CONTEXT, SHIM_QUEUE, SHIM_PROGRAM, SHIM_KERNEL, SHIM_BUFFER, SHIM_EVENT, SHIM_OBJECTS };
typedef struct shim_count {
    long created, released;
} shim_count;
extern const char *const shim_object_names[SHIM_OBJECTS];
/* Returns the number of objects of this kind created and released since the program's start. */
shim_count shim_objects(enum shim_object kind);
/* Returns the number of objects of all kinds that have been created and not yet released. */
long shim_alive(void);
bool shim_goes_to_queue(enum shim_call call);

#endif
