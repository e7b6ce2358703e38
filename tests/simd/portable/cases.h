/* SPDX-License-Identifier: Apache-2.0 */
/* The intrinsics that immintrin.h supplies, called with random arguments. */
#ifndef OST_TESTS_SIMD_PORTABLE_CASES_H
#define OST_TESTS_SIMD_PORTABLE_CASES_H

#include <stdint.h>

/*
 * The arguments of the intrinsics. Some lanes of `a` and `b` are equal, for comparisons, and some are small, for shift
 * counts.
 */
typedef struct intrinsic_input {
    _Alignas(64) uint8_t a[64], b[64];
    _Alignas(64) float f[16], g[16];
    _Alignas(64) double d[8];
    uint64_t mask;
} intrinsic_input;

typedef struct intrinsic_case {
    const char *name;
    /* FNV-1a hash of the results for the test's arguments, recorded from a processor */
    uint64_t recorded;
    void (*run)(const intrinsic_input *in, uint8_t out[64]); /* changes only the bytes of the result */
} intrinsic_case;

/* Two lists of the same cases in the same order. The last entry of each list has the name NULL. */
extern const intrinsic_case intrinsics_portable[], intrinsics_native[];

#endif
