/* SPDX-License-Identifier: Apache-2.0 */
/* Converts an OpenCL error code to a status and a line of text that names the call, the device and the cause. */
#ifndef OST_CL_ERROR_H
#define OST_CL_ERROR_H

#include <osteon/status.h>

#include "cl/api.h"

/* Returns the name of an error code, such as "CL_OUT_OF_RESOURCES", or "an unknown error" if the code is not listed. */
const char *ost_cl_error_name(cl_int code);

/* Sets the message for the user and returns the status that corresponds to the code. `device` is the name of the
   device, `call` is the name of the OpenCL function that failed, and `what` names the object ("kernel ost_remove") or
   is "". */
ost_status ost_cl_fail(ost_error *err, const char *device, cl_int code, const char *call, const char *what);

#endif
