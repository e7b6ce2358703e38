/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Kernels with one small error each. test_checksimd.c tests that checksimd detects these errors. Each family of
 * kernels has a file wrong_FAMILY.c with a list.
 *
 * Most of the wrong kernels call the scalar kernel and cause an error before or after the call.
 */
#ifndef OST_TESTS_SIMD_WRONG_H
#define OST_TESTS_SIMD_WRONG_H

#include "simd/check.h"

typedef struct wrong {
    const check_kernel *kernel;
    check_fn *fn;
    unsigned found_as; /* set of the accepted check_result values */
    const char *what;
} wrong;

typedef struct wrong_list {
    const wrong *first;
    int count;
} wrong_list;

extern const wrong_list wrong_grids, wrong_remove, wrong_voxelize, wrong_text;

/* The set that consists of the check_result values a and b. */
#define OR(a, b) (1u << (a) | 1u << (b))
#define DIFFERS (1u << CHECK_DIFFERS)
#define FAULT (1u << CHECK_FAULT)
#define STATE (1u << CHECK_STATE)
#define BEYOND OR(CHECK_BEYOND, CHECK_FAULT)
/* An element of a list: the wrong kernel `fn` of a slot, and the set of results that may be reported for it. */
#define WRONG(slot, fn, found_as) {&check_##slot, (check_fn *)(fn), found_as, #fn}

/* Reads a byte; volatile prevents the compiler from removing the read. */
static inline void touch(const void *p)
{
    (void)*(const volatile char *)p;
}

/* Removes const from a pointer, so that a wrong kernel can write to its input. */
static inline void *writable(const void *p)
{
    return (void *)(uintptr_t)p;
}

#endif
