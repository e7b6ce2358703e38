/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact integer division (docs/spec/arithmetic.md, AR-INT): floor, ceiling, and
 * RHE (round half to even).  Divisors must be positive, and the quotient must fit
 * in the result type.
 */
#ifndef OST_CORE_INTEGER_H
#define OST_CORE_INTEGER_H

#include <stdint.h>

#include "core/conditions.h"

__extension__ typedef __int128 ost_i128;

static inline int64_t ost_floor_div(int64_t n, int64_t d)
{
    int64_t q = n / d;
    return q - (n % d < 0);
}

static inline int64_t ost_ceil_div(int64_t n, int64_t d)
{
    int64_t q = n / d;
    return q + (n % d > 0);
}

static inline ost_i128 ost_floor_div128(ost_i128 n, ost_i128 d)
{
    ost_i128 q = n / d;
    return q - (n % d < 0);
}

/*
 * Returns RHE(n / d). Let q = floor(n / d) and r = n - q d, so that 0 <= r < d. The result is q + 1 if r > d - r, or if
 * r = d - r and q is odd; otherwise, it is q. r is compared with d - r because 2 r could overflow.
 */
static inline int64_t ost_rhe_div(int64_t n, int64_t d)
{
    int64_t q = ost_floor_div(n, d);
    int64_t r = n - q * d;
    return q + (r > d - r || (r == d - r && (q & 1)));
}

static inline ost_i128 ost_rhe_div128(ost_i128 n, ost_i128 d)
{
    ost_i128 q = ost_floor_div128(n, d);
    ost_i128 r = n - q * d;
    return q + (r > d - r || (r == d - r && (q & 1)));
}

#endif
