/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Divides many numbers exactly by the same divisor. The only division computes the divisor's reciprocal. Each quotient
 * is estimated by a multiplication with the reciprocal. The remainder shows whether the estimate must be corrected, by
 * at most one.
 *
 * Let D be the divisor, and let n be the dividend. Let s be the integer for which d = floor(D / 2^s) is in
 * [2^61, 2^62); for s < 0, d = D 2^-s. Let I = floor(2^124 / (d + 1)), which is in [2^62, 2^63). The estimate is e:
 *
 *     h = floor(n / 2^(s+46))       e = floor(h I / 2^78)
 *
 * Let X = 2^(124+s) / D, so that n / D = n / 2^(s+46) * X / 2^78.
 *   0 <= X - I <= 5      as X <= 2^124 / d, which is at most 4 above 2^124 / (d + 1)
 *   n / 2^(s+46) = h + f, 0 <= f < 1
 *   n / D - h I / 2^78 = (h (X - I) + f X) / 2^78
 * With |n| <= 2^46 D, and therefore |h| <= 2^62 + 1, the magnitude of this difference is
 * below (5 (2^62 + 1) + 2^63) / 2^78 < 2^-12, so e differs from floor(n / D) by at most one.
 *
 * Ranges: |h I| < 2^126; the remainder is within [-D, 2 D) before it is
 * corrected, so |e D| <= |n| + 2 D, which fits in 128 bits for |n| < 2^126 and D <= 2^120.
 */
#ifndef OST_CORE_DIVIDER_H
#define OST_CORE_DIVIDER_H

#include <assert.h>

#include "core/integer.h"

typedef struct ost_divider {
    ost_i128 divisor;
    /* I = floor(2^124 / (d + 1)), the scaled reciprocal that the comment at the top of this file derives */
    int64_t inverse;
    int shift;       /* number of bits by which the dividend is shifted to the right, s + 46; never negative */
} ost_divider;

/* Prepares repeated divisions by the same divisor, which must be in 2^15..2^120. */
static inline ost_divider ost_divider_of(ost_i128 divisor)
{
    const uint64_t high = (uint64_t)(divisor >> 64), low = (uint64_t)divisor;
    assert(divisor >= 1 << 15 && divisor <= (ost_i128)1 << 120);
    const int bits = high ? 128 - __builtin_clzll(high) : 64 - __builtin_clzll(low), s = bits - 62;
    const uint64_t d = s < 0 ? low << -s : (uint64_t)(divisor >> s);
    __extension__ typedef unsigned __int128 u128;
    return (ost_divider){.divisor = divisor, .inverse = (int64_t)(((u128)1 << 124) / (d + 1)), .shift = s + 46};
}

/*
 * Returns floor(n / divisor) for |n| <= 2^46 * divisor and |n| < 2^126. *remainder is set to the remainder, 0 to
 * divisor - 1.
 */
static inline int64_t ost_floor_by(const ost_divider *by, ost_i128 n, ost_i128 *remainder)
{
    int64_t q = (int64_t)((ost_i128)(int64_t)(n >> by->shift) * by->inverse >> 78);
    ost_i128 r = n - q * by->divisor;
    if (r < 0) {
        q--;
        r += by->divisor;
    } else if (r >= by->divisor) {
        q++;
        r -= by->divisor;
    }
    *remainder = r;
    return q;
}

/* Returns n / divisor, rounded half to even. n must be in the range that ost_floor_by requires. */
static inline int64_t ost_rhe_by(const ost_divider *by, ost_i128 n)
{
    ost_i128 r;
    const int64_t q = ost_floor_by(by, n, &r);
    return q + (r > by->divisor - r || (r == by->divisor - r && (q & 1)));
}

#endif
