/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Functions shared by the tests of the cl backend. These tests need OpenCL and a device. If either is missing,
 * the tests are skipped, and the reason is printed. Binaries are cached in the build folder. OST_TEST_CL selects the
 * device, and OST_TEST_ONLY selects the tests:
 *
 *   OST_TEST_CL=cl:platform=rusticl RUSTICL_ENABLE=llvmpipe tests/cl/test_cl_stages
 *   OST_TEST_ONLY='cache_*' tests/cl/test_cl_cache
 */
#ifndef OST_TESTS_CL_ON_DEVICE_H
#define OST_TESTS_CL_ON_DEVICE_H

#include "harness.h"

#include <sys/stat.h>
#include <unistd.h>

#include <osteon/backend.h>

enum { SKIPPED = 77 };

/*
 * Drivers free a part of their memory only when the program ends, or never, so leaks in drivers are
 * suppressed. The suppression also hides OpenCL objects that osteon does not release; tests/cl/shim.c
 * counts these objects.
 */
#if defined __SANITIZE_ADDRESS__
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libpocl\nleak:libLLVM\nleak:libOpenCL\nleak:libRusticl\nleak:libMesaOpenCL\nleak:libclang";
}
#endif

static inline const char *device_spec(void)
{
    const char *spec = getenv("OST_TEST_CL");
    return spec && spec[0] ? spec : "cl";
}

/* Copies the device's spec to out and appends one option. */
static inline void spec_with(char *out, size_t size, const char *option)
{
    const char *spec = device_spec();
    snprintf(out, size, "%s%c%s", spec, strchr(spec, ':') ? ',' : ':', option);
}

/* Returns 0 if there is a device; otherwise prints the reason and returns SKIPPED. */
static inline int device_missing(void)
{
    char folder[4096];
    cmocka_set_test_filter(getenv("OST_TEST_ONLY"));
    if (!getcwd(folder, sizeof folder - 32))
        return SKIPPED;
    strcat(folder, "/tests/cl/cache");
    mkdir(folder, 0700);
    setenv("XDG_CACHE_HOME", folder, 1);
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info;
        if (ost_backend_describe(i, &info, NULL) != OST_OK || strcmp(info.name, "cl") != 0)
            continue;
        if (info.available)
            return 0;
        printf("skipped: %s\n", info.reason);
    }
    return SKIPPED;
}

#endif
