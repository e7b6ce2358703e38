/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

/* Proves that ost_floor_div and ost_ceil_div do not overflow for any n and any d >= 1. */
void integer_floor(void)
{
    const int64_t n = nondet_int64(), d = nondet_int64();
    ASSUME(d >= 1 - WIDER);
    (void)ost_floor_div(n, d);
    (void)ost_ceil_div(n, d);
}

/* Proves that q * d, n - q * d and d - r do not overflow for |n| and d up to 2^62. */
void integer_rhe(void)
{
    const int64_t n = nondet_int64(), d = nondet_int64(), limit = INT64_C(1) << 62;
    if (!WIDER)
        WITHIN(n, limit);
    ASSUME(d >= 1 && (WIDER || d <= limit));
    (void)ost_rhe_div(n, d);
}
