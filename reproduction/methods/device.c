/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the OpenCL device of the methods, and builds their programs. */
#include "reproduction/methods/device.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef HAVE_OPENCL
struct method_device *method_device_open(const char *spec, char reason[BENCH_TEXT])
{
    struct method_device *device = calloc(1, sizeof *device);
    if (!device) {
        snprintf(reason, BENCH_TEXT, "out of memory for an OpenCL device");
        return NULL;
    }
    if (bench_device_open(&device->cl, spec, reason))
        return device;
    free(device);
    return NULL;
}

void method_device_close(struct method_device *device)
{
    if (!device)
        return;
    bench_device_close(&device->cl);
    free(device);
}

ost_status method_device_check(cl_int code, const char *call, ost_error *err)
{
    return code == CL_SUCCESS ? OST_OK
                              : ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL: %s failed with code %d", call, (int)code);
}

ost_status method_device_build(struct method_device *device, const char *source, cl_program *out, ost_error *err)
{
    cl_int code;
    *out = clCreateProgramWithSource(device->cl.context, 1, &source, NULL, &code);
    ost_status status = method_device_check(code, "clCreateProgramWithSource", err);
    if (status == OST_OK)
        status = method_device_check(clBuildProgram(*out, 1, &device->cl.id, "-cl-std=CL1.2", NULL, NULL),
                                     "clBuildProgram", err);
    return status;
}
#else
struct method_device *method_device_open(const char *spec, char reason[BENCH_TEXT])
{
    (void)spec;
    snprintf(reason, BENCH_TEXT, "OpenCL is not built in; Debian: ocl-icd-opencl-dev, opencl-headers");
    return NULL;
}

void method_device_close(struct method_device *device)
{
    (void)device;
}
#endif
