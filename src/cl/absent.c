/* SPDX-License-Identifier: Apache-2.0 */
/* The `cl` backend in a build without OpenCL. The backend only reports why it is unavailable. */
#include "core/backend.h"

#include <stdio.h>

static bool available(char *reason, size_t size)
{
    snprintf(reason, size,
             "built without OpenCL; install opencl-headers and ocl-icd-opencl-dev, configure and build again");
    return false;
}

static ost_status open_cl(const char *options, ost_backend **out, ost_error *err)
{
    char reason[256];
    (void)options;
    *out = NULL;
    available(reason, sizeof reason);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "backend cl: %s", reason);
}

const ost_backend_ops ost_backend_cl = {
    .name = "cl",
    .description = "OpenCL 1.2 devices",
    .available = available,
    .devices = ost_no_devices,
    .open = open_cl,
};
