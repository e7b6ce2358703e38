/* SPDX-License-Identifier: Apache-2.0 */
/* Selects an OpenCL device by its platform number and its device number, as the backend cl does. Creates a context
   and an in-order queue on this device. */
#include "config.h"

#ifdef HAVE_OPENCL
#include "bench/device_cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Sets *out to the number after `key` ("device=") in a backend's options, or to 0 if the option is not
   given. Returns false if the value is not a number from 0 to 63. */
static bool number_of(const char *backend, const char *key, int *out)
{
    const char *at = strncmp(backend, "cl:", 3) == 0 ? strstr(backend, key) : NULL;
    char *end = NULL;
    *out = 0;
    if (!at)
        return true;
    long n = strtol(at + strlen(key), &end, 10);
    *out = (int)n;
    return end != at + strlen(key) && (*end == 0 || *end == ',') && n >= 0 && n < 64;
}

static bool find_device(bench_device *device, const char *backend, char reason[BENCH_TEXT])
{
    cl_platform_id platforms[64];
    cl_device_id devices[64];
    cl_uint count = 0;
    int platform, index;
    if (!number_of(backend, "platform=", &platform) || !number_of(backend, "device=", &index)) {
        snprintf(reason, BENCH_TEXT, "this suite takes platform= and device= as numbers; osteon devices shows them");
        return false;
    }
    if (clGetPlatformIDs(64, platforms, &count) != CL_SUCCESS || (cl_uint)platform >= count) {
        snprintf(reason, BENCH_TEXT, "OpenCL has no platform %d here; osteon devices shows what there is", platform);
        return false;
    }
    if (clGetDeviceIDs(platforms[platform], CL_DEVICE_TYPE_ALL, 64, devices, &count) != CL_SUCCESS ||
        (cl_uint)index >= count) {
        snprintf(reason, BENCH_TEXT, "OpenCL platform %d has no device %d; osteon devices shows what there is",
                 platform, index);
        return false;
    }
    device->id = devices[index];
    snprintf(device->spec, sizeof device->spec, "cl:platform=%d,device=%d", platform, index);
    clGetDeviceInfo(device->id, CL_DEVICE_NAME, sizeof device->name - 1, device->name, NULL);
    return true;
}

bool bench_device_open(bench_device *device, const char *backend, char reason[BENCH_TEXT])
{
    cl_int code;
    *device = (bench_device){.id = NULL};
    if (!find_device(device, backend, reason))
        return false;
    device->context = clCreateContext(NULL, 1, &device->id, NULL, NULL, &code);
    device->queue = device->context ? clCreateCommandQueue(device->context, device->id, 0, &code) : NULL;
    if (device->queue)
        return true;
    snprintf(reason, BENCH_TEXT, "OpenCL device '%.100s' gives no context with a queue", device->name);
    bench_device_close(device);
    return false;
}

void bench_device_close(bench_device *device)
{
    if (device->queue)
        clReleaseCommandQueue(device->queue);
    if (device->context)
        clReleaseContext(device->context);
    device->queue = NULL;
    device->context = NULL;
}
#else
typedef int bench_device_cl_is_empty; /* ISO C forbids an empty translation unit */
#endif
