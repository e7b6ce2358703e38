/* SPDX-License-Identifier: Apache-2.0 */
/* The random number generator of all tests. It returns the same numbers on every machine. */
#ifndef OST_TESTS_RNG_H
#define OST_TESTS_RNG_H

#include <stdint.h>

/* splitmix64 */
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

/* Returns a number with lo <= number <= hi. */
static inline int64_t rng_range(test_rng *rng, int64_t lo, int64_t hi)
{
    uint64_t span = (uint64_t)hi - (uint64_t)lo + 1;
    return (int64_t)((uint64_t)lo + (span ? rng_next(rng) % span : rng_next(rng)));
}

#endif
