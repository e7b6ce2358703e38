/* SPDX-License-Identifier: Apache-2.0 */
/* Converts OpenCL's error codes to a status and one line that names call, device and cause. */
#ifndef OST_CL_ERROR_H
#define OST_CL_ERROR_H

#include <osteon/status.h>

#include "cl/api.h"

/* Returns the name, such as "CL_OUT_OF_RESOURCES"; "an unknown error" for a code that is not listed. */
const char *ost_cl_error_name(cl_int code);

/* Sets the user's message and returns the status that corresponds to the code. `device` is the device's name, `call` is
   the name of the OpenCL function that failed, and `what` is the object concerned ("kernel ost_remove") or "". */
ost_status ost_cl_fail(ost_error *err, const char *device, cl_int code, const char *call, const char *what);

#endif
