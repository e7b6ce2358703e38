/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every test starts from: cmocka, a seeded generator whose seed is
 * printed and can be given, and a scratch folder.
 *
 *   OST_TEST_SEED=123 tests/core/test_length     replays a property test
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

/* splitmix64: small, seedable, the same everywhere. */
typedef struct test_rng {
    uint64_t state;
} test_rng;

static inline uint64_t rng_next(test_rng *rng)
{
    uint64_t z = (rng->state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* lo <= result <= hi */
static inline int64_t rng_range(test_rng *rng, int64_t lo, int64_t hi)
{
    uint64_t span = (uint64_t)hi - (uint64_t)lo + 1;
    return (int64_t)((uint64_t)lo + (span ? rng_next(rng) % span : rng_next(rng)));
}

/* A seed from OST_TEST_SEED, else from the clock; printed, so that a failure can be replayed. */
static inline test_rng rng_seeded(const char *what)
{
    const char *given = getenv("OST_TEST_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 0) : (uint64_t)time(NULL) * 2654435761u ^ (uint64_t)clock();
    printf("# %s: OST_TEST_SEED=%llu\n", what, (unsigned long long)seed);
    return (test_rng){seed};
}

/* Fails the test with the error's own text. */
#define assert_ok(call)                                                                             \
    do {                                                                                            \
        ost_status assert_ok_status = (call);                                                       \
        if (assert_ok_status != OST_OK)                                                             \
            fail_msg("%s: %s (%s)", #call, ost_status_name(assert_ok_status), err.text);            \
    } while (0)

#endif
