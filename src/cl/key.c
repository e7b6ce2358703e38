/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Collects the strings on which a built program depends.  Together, these strings determine
 * the key of the program's cache entry:
 *
 *   options, sources          of this library
 *   platform, device, driver  their names and versions
 *   NAME=VALUE ...            driver settings in the environment, sorted
 *
 * Environment variables control drivers: for example, POCL_KERNELLIB_NAME and
 * POCL_WORK_GROUP_METHOD change the machine code, but not the name or version of the driver.  It is
 * not known which variables affect the binary, so all variables with a driver's prefix are
 * included.  An unnecessary build takes only seconds.  With a binary that was built with other
 * settings, however, a campaign would not test the current settings.  Cache folders (*_CACHE_DIR)
 * are excluded.
 */
#include "cl/cl.h"

#include <stdlib.h>
#include <string.h>

#include "cl/cache.h"

extern char **environ;

static bool is_setting(const char *variable)
{
    static const char *const prefixes[] = {"POCL_", "RUSTICL_", "MESA_", "GALLIUM_", "GALLIVM_", "LP_",
                                           "CLC_",  "CL_",      "IGC_",  "NEO_",     "ZE_",      "AMD_",
                                           "GPU_",  "ROC_",     "CUDA_", "OCLGRIND_"};
    const size_t name = strcspn(variable, "=");
    if (name >= 10 && strncmp(variable + name - 10, "_CACHE_DIR", 10) == 0)
        return false;
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++)
        if (strncmp(variable, prefixes[i], strlen(prefixes[i])) == 0)
            return true;
    return false;
}

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Returns the number of driver settings in the environment. If `parts` is not NULL, also stores the settings in
   `parts`, sorted. */
static size_t settings(const char **parts)
{
    size_t count = 0;
    for (char **e = environ; e && *e; e++)
        if (is_setting(*e)) {
            if (parts)
                parts[count] = *e;
            count++;
        }
    if (parts)
        qsort(parts, count, sizeof *parts, by_text);
    return count;
}

ost_status ost_cl_key(const ost_cl_device *d, const char *const *sources, size_t count, const char *options,
                      ost_cl_cache *cache, ost_error *err)
{
    const char *const about[] = {options, d->platform_name, d->platform_version, d->name, d->driver};
    enum { ABOUT = sizeof about / sizeof about[0] };
    const char **parts = malloc((ABOUT + count + settings(NULL)) * sizeof *parts);
    if (!parts)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the kernels' sources");
    memcpy(parts, about, sizeof about);
    for (size_t i = 0; i < count; i++)
        parts[ABOUT + i] = sources[i];
    const size_t all = ABOUT + count + settings(parts + ABOUT + count);
    ost_status status = ost_cl_cache_key(cache, parts, all, err);
    free(parts);
    return status;
}
