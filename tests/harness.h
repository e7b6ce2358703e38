/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Common base of all tests: cmocka, a random number generator whose seed is printed and can be set, and assert_ok.
 *
 *   OST_TEST_SEED=123 tests/core/test_length     repeats a property test
 */
#ifndef OST_TESTS_HARNESS_H
#define OST_TESTS_HARNESS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include <osteon/status.h>

#include "rng.h"

/*
 * Returns a random number generator and prints its seed, so that a failure can be repeated. The seed is the value of
 * OST_TEST_SEED or, if that is not set, comes from the clock.
 */
static inline test_rng rng_seeded(const char *what)
{
    const char *given = getenv("OST_TEST_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 0) : (uint64_t)time(NULL) * 2654435761u ^ (uint64_t)clock();
    printf("# %s: OST_TEST_SEED=%llu\n", what, (unsigned long long)seed);
    return (test_rng){seed};
}

/* Fails the test and prints the text of the caller's variable `err` if the call does not return OST_OK. */
#define assert_ok(call)                                                                             \
    do {                                                                                            \
        ost_status assert_ok_status = (call);                                                       \
        if (assert_ok_status != OST_OK)                                                             \
            fail_msg("%s: %s (%s)", #call, ost_status_name(assert_ok_status), err.text);            \
    } while (0)

#endif
