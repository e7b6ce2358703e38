/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/backend_choice.h"

#include <stdio.h>
#include <string.h>

#include "app/common/options.h"
#include "app/common/progress.h"

bool backend_is(const app_state *app, const char *name)
{
    return spec_is(app->backend, name);
}

/* Opens the backend of --backend. For an OpenCL device, shows a progress line, because the device's driver compiles
   the kernels at the first start on a machine. */
static ost_status open_as_given(const app_state *app, ost_backend **out, ost_error *err)
{
    if (!backend_is(app, "cl"))
        return ost_backend_open(app->backend, out, err);
    progress_show(NULL, "opening the OpenCL device", 0);
    const ost_status status = ost_backend_open(app->backend, out, err);
    progress_end();
    return status;
}

ost_status backend_choose(const app_state *app, ost_backend **out, ost_error *err)
{
    if (!app->threads || !backend_is(app, "cpu"))
        return open_as_given(app, out, err);
    if (strstr(app->backend, "threads="))
        return ost_fail(err, OST_ERR_USAGE,
                        "--threads %lld and --backend %.80s both set the number of threads; pass one of them",
                        (long long)app->threads, app->backend);
    const char *options = strchr(app->backend, ':');
    char spec[256];
    const int n = snprintf(spec, sizeof spec, "cpu:threads=%lld%s%s", (long long)app->threads,
                           options && options[1] ? "," : "", options ? options + 1 : "");
    if (n < 0 || (size_t)n >= sizeof spec)
        return ost_fail(err, OST_ERR_USAGE, "backend '%.60s...': too long", app->backend);
    return ost_backend_open(spec, out, err);
}
