/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a group of tests on several backends, one after another:
 *
 *   OST_TEST_BACKENDS="ref cpu:isa=avx2,threads=7" tests/ref/test_remove
 *
 * The default list consists of the reference, the cpu backend with its default instruction set and 2
 * threads, and the cpu backend with scalar loops and 3 threads. .ci/long runs all combinations. Each test
 * contains its expected values, so it passes on all backends only if their grids are bit-identical.
 */
#ifndef OST_TESTS_BACKENDS_H
#define OST_TESTS_BACKENDS_H

#include "harness.h"

#include <osteon/backend.h>

/* Spec of the backend on which the current group runs; "ref" before the first group. */
static char test_backend[100] = "ref";

static inline const char *test_backends(void)
{
    const char *given = getenv("OST_TEST_BACKENDS");
    return given && *given ? given : "ref cpu:threads=2 cpu:isa=scalar,threads=3";
}

static inline int open_test_backend(void **state)
{
    ost_error err = {0};
    if (ost_backend_open(test_backend, (ost_backend **)state, &err) == OST_OK)
        return 0;
    print_error("%s\n", err.text);
    return 1;
}

static inline int close_test_backend(void **state)
{
    ost_backend_close(*state);
    return 0;
}

/* Skips the test if the backend cannot read voxels during a tick. Tests that need a force must call this function. */
static inline void skip_without_samples(ost_backend *backend)
{
    const ost_geometry one = {{1, 1, 1}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    const int32_t first = 0, *const at[3] = {&first, &first, &first};
    ost_error err = {0};
    ost_bone *bone;
    int16_t density;
    assert_ok(ost_bone_create(backend, &one, 32, 120, &bone, &err));
    const ost_status status = ost_bone_sample(bone, 1, at, &density, &err);
    ost_bone_free(bone);
    if (status == OST_ERR_UNAVAILABLE) {
        print_message("# %s\n", err.text);
        skip();
    }
    assert_ok(status);
}

/*
 * Copies the next entry of the list to test_backend. *at must be NULL before the first call. Returns false after the
 * last entry.
 */
static inline bool next_test_backend(const char **at)
{
    *at = *at ? *at : test_backends();
    *at += strspn(*at, " ");
    const size_t length = strcspn(*at, " ");
    if (length == 0)
        return false;
    if (length >= sizeof test_backend) {
        print_error("OST_TEST_BACKENDS: '%.40s...' is too long\n", *at);
        exit(99);
    }
    memcpy(test_backend, *at, length);
    test_backend[length] = 0;
    *at += length;
    print_message("# backend %s\n", test_backend);
    return true;
}

/*
 * Returns the number of random trials. With OST_TEST_LONG=1, the number is n on every backend. Otherwise, it is n on
 * the first backend and a third of n on each other backend.
 */
static inline int test_rounds(int n)
{
    const char *lengthy = getenv("OST_TEST_LONG");
    const char *first = test_backends() + strspn(test_backends(), " ");
    const size_t length = strlen(test_backend);
    const bool all = (lengthy && strcmp(lengthy, "1") == 0) ||
                     (strncmp(first, test_backend, length) == 0 && strchr(" ", first[length]));
    return all ? n : (n + 2) / 3;
}

/* Runs cmocka_run_group_tests on each backend and returns the number of failures. */
#define run_on_backends(tests, set_up, tear_down)                                            \
    __extension__({                                                                          \
        int run_failures = 0;                                                                \
        for (const char *run_at = NULL; next_test_backend(&run_at);)                         \
            run_failures += cmocka_run_group_tests_name(test_backend, tests, set_up, tear_down); \
        run_failures;                                                                        \
    })

#endif
