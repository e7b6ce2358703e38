/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The OpenCL device for the methods whose publication used a GPU. In a build without OpenCL, the functions report that
 * OpenCL is missing.
 */
#ifndef OST_REPRODUCTION_METHODS_DEVICE_H
#define OST_REPRODUCTION_METHODS_DEVICE_H

#include "reproduction/methods/method.h"

#include "config.h"

#ifdef HAVE_OPENCL
#include "bench/device_cl.h"

struct method_device {
    bench_device cl;
};

/* Compiles the kernels in `source` for the device. */
ost_status method_device_build(struct method_device *device, const char *source, cl_program *out, ost_error *err);
/* Returns OST_OK for CL_SUCCESS, and otherwise OST_ERR_BACKEND with the name of the OpenCL call. */
ost_status method_device_check(cl_int code, const char *call, ost_error *err);
#endif

/* Opens the device selected by `spec`, such as "cl:platform=0,device=0". Returns NULL and the reason on failure. */
struct method_device *method_device_open(const char *spec, char reason[BENCH_TEXT]);
void method_device_close(struct method_device *device); /* device may be NULL */

#endif
