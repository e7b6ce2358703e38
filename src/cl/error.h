/* SPDX-License-Identifier: Apache-2.0 */
/* OpenCL's error codes as statuses and as one line that names call, device and cause. */
#ifndef OST_CL_ERROR_H
#define OST_CL_ERROR_H

#include <osteon/status.h>

#include "cl/api.h"

/* "CL_OUT_OF_RESOURCES"; "error -9999" for one that is in no list here. */
const char *ost_cl_error_name(cl_int code);

/* What the user is told; device names it, call is the function's name, what its object ("kernel ost_remove"). */
ost_status ost_cl_fail(ost_error *err, const char *device, cl_int code, const char *call, const char *what);

#endif
