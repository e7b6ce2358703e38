/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens the device that OST_TEST_CL selects. The test passes the table of OpenCL functions, some of which may be
 * replaced.
 */
#ifndef OST_TESTS_CL_TRY_OPEN_H
#define OST_TESTS_CL_TRY_OPEN_H

#include "cl/on_device.h"

#include "cl/cl.h"
#include "cl/kernels/shared.h"

/* Returns the options in the spec of the device. */
static inline const char *own_options(void)
{
    const char *colon = strchr(device_spec(), ':');
    return colon ? colon + 1 : "";
}

/*
 * Opens the device with the OpenCL functions `cl` and the options `text`, and closes it if it was opened. Returns the
 * status of opening.
 */
static inline ost_status try_open(const ost_cl_api *cl, const char *text, ost_error *err)
{
    ost_backend *backend;
    *err = (ost_error){0};
    ost_status status = ost_cl_open_with(cl, text, &backend, err);
    if (status == OST_OK) {
        backend->ops = &ost_backend_cl;
        ost_backend_close(backend);
    } else {
        assert_null(backend);
    }
    return status;
}

#endif
