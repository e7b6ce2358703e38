/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "core/divider.h"

/* Proves the bounds of the inverse I and of the shift for any divisor. The casts to 64 bits discard bits
   intentionally. */
void divider_inverse(void)
{
    const ost_i128 divisor = nondet_int128();
    ASSUME(divisor >= (WIDER ? 1 : 1 << 15) && divisor <= (ost_i128)1 << 120);
    const ost_divider by = ost_divider_of(divisor);
    ASSERT(by.inverse >= INT64_C(1) << 62 && by.shift >= 0 && by.shift <= 105);
}

/*
 * Proves that h and h * I do not overflow for dividends |n| <= 2^46 * D, where D is the divisor. The proof uses a copy
 * of the expressions. The product 2^46 * D may exceed 128 bits, so the copy compares n / 2^46 with D.
 */
void divider_estimate(void)
{
    const ost_divider by = {.divisor = nondet_int128(), .inverse = nondet_int64(), .shift = any32(0, 105)};
    const ost_i128 n = nondet_int128();
    ASSUME(by.divisor >= 1 << 15 && by.divisor >> (by.shift + 15) == 1);
    ASSUME(by.inverse >= INT64_C(1) << 62);
    ASSUME(n >> 46 + 2 * WIDER <= by.divisor && n >> 46 + 2 * WIDER >= -by.divisor - 1);
    const int64_t h = (int64_t)(n >> by.shift);
    const int64_t e = (int64_t)((ost_i128)h * by.inverse >> 78);
    BOUNDED(e, (INT64_C(1) << 47) + 1);
}
