/* SPDX-License-Identifier: Apache-2.0 */
#include "app/backend_choice.h"

#include <stdio.h>
#include <string.h>

bool backend_cpu_stands_in(void)
{
    ost_backend_info info;
    for (int i = 0; i < ost_backend_count(); i++)
        if (ost_backend_describe(i, &info, NULL) == OST_OK && strcmp(info.name, "cpu") == 0)
            return false;
    return true;
}

/* Whether options hold nothing but threads=N: the one that may go unheard, since it never changes a result. */
static bool only_threads(const char *options)
{
    return strncmp(options, "threads=", 8) == 0 && !strchr(options, ',');
}

ost_status backend_choose(const app_state *app, ost_backend **out, ost_error *err)
{
    size_t name_length = strcspn(app->backend, ":");
    const char *options = app->backend[name_length] == ':' ? app->backend + name_length + 1 : "";
    bool cpu = name_length == 3 && strncmp(app->backend, "cpu", 3) == 0;
    if (cpu && backend_cpu_stands_in()) {
        if (*options && !only_threads(options))
            return ost_fail(err, OST_ERR_UNAVAILABLE,
                            "backend '%s': this build has no CPU backend, and the reference that stands in for it has no option %s",
                            app->backend, options);
        return ost_backend_open("ref", out, err);
    }
    if (cpu && app->threads && !strstr(options, "threads=")) {
        char spec[256];
        int n = snprintf(spec, sizeof spec, "%s%cthreads=%lld", app->backend, *options ? ',' : ':', (long long)app->threads);
        if (n < 0 || (size_t)n >= sizeof spec)
            return ost_fail(err, OST_ERR_USAGE, "backend '%.60s...': too long", app->backend);
        return ost_backend_open(spec, out, err);
    }
    return ost_backend_open(app->backend, out, err);
}
