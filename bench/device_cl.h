/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An OpenCL device with a context and an in-order queue, for kernels whose times are compared with the
 * times of osteon's kernels. This header may be included only where HAVE_OPENCL is defined (config.h).
 */
#ifndef OST_BENCH_DEVICE_CL_H
#define OST_BENCH_DEVICE_CL_H

#include "bench/bench.h"

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

typedef struct bench_device {
    char spec[64]; /* options string with which the backend cl opens the same device */
    char name[128];
    cl_device_id id;
    cl_context context;     /* owned, like the queue */
    cl_command_queue queue;
} bench_device;

/*
 * Opens the device whose platform and device numbers are in the string `backend`, such as "cl:platform=0,device=1". A
 * missing number is 0. If the string names a backend other than cl, both numbers are 0. Returns false and the reason if
 * the device does not exist or cannot be opened.
 */
bool bench_device_open(bench_device *device, const char *backend, char reason[BENCH_TEXT]);
void bench_device_close(bench_device *device); /* may be called more than once */

#endif
