/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The loader's calls with failures made to order: the n-th call of one
 * function is refused with a code, and on request everything after it too, as
 * when a device is lost.  No driver knows of it.
 */
#ifndef OST_TESTS_CL_SHIM_H
#define OST_TESTS_CL_SHIM_H

#include "cl/cl.h"

/* clang-format off */
#define SHIM_CALLS(X) \
    X(clGetPlatformIDs, CL_OUT_OF_HOST_MEMORY) X(clGetDeviceIDs, CL_DEVICE_NOT_FOUND) X(clGetDeviceInfo, CL_INVALID_DEVICE) \
    X(clCreateContext, CL_DEVICE_NOT_AVAILABLE) X(clCreateCommandQueue, CL_OUT_OF_RESOURCES) \
    X(clCreateProgramWithSource, CL_OUT_OF_HOST_MEMORY) X(clCreateProgramWithBinary, CL_INVALID_BINARY) \
    X(clBuildProgram, CL_BUILD_PROGRAM_FAILURE) X(clCreateKernel, CL_INVALID_KERNEL_NAME) \
    X(clGetKernelWorkGroupInfo, CL_INVALID_KERNEL) X(clSetKernelArg, CL_INVALID_ARG_VALUE) \
    X(clCreateBuffer, CL_MEM_OBJECT_ALLOCATION_FAILURE) X(clEnqueueReadBuffer, CL_OUT_OF_RESOURCES) \
    X(clEnqueueWriteBuffer, CL_OUT_OF_RESOURCES) X(clEnqueueCopyBuffer, CL_OUT_OF_RESOURCES) \
    X(clEnqueueFillBuffer, CL_OUT_OF_HOST_MEMORY) X(clEnqueueNDRangeKernel, CL_OUT_OF_RESOURCES) X(clFinish, CL_DEVICE_NOT_AVAILABLE)
/* clang-format on */

enum shim_call {
#define SHIM_ENUM(name, code) SHIM_##name,
    SHIM_CALLS(SHIM_ENUM)
#undef SHIM_ENUM
    SHIM_COUNT
};

extern const char *const shim_names[SHIM_COUNT];
extern const ost_cl_api shim;

/* The n-th call from now on, 1 is the next, fails; lost: and everything that goes to the queue after it. n = 0: none. */
void shim_fail(enum shim_call call, int n, bool lost);
/* The same, lost, but heard of only by who waits: until then everything is taken and nothing done. */
void shim_fail_late(enum shim_call call, int n);
/* Whether it has come to that. */
bool shim_failed(void);
/* Of every kind of object that the backend makes: how many it was given, and how many it gave back. */
enum shim_object { SHIM_CONTEXT, SHIM_QUEUE, SHIM_PROGRAM, SHIM_KERNEL, SHIM_BUFFER, SHIM_EVENT, SHIM_OBJECTS };
typedef struct shim_count {
    long created, released;
} shim_count;
extern const char *const shim_object_names[SHIM_OBJECTS];
/* Since the start. */
shim_count shim_objects(enum shim_object kind);
/* Objects of any kind created and not yet released. */
long shim_alive(void);
bool shim_goes_to_queue(enum shim_call call);

#endif
