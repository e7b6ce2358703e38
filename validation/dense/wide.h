/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 256-bit integers as sign and magnitude. The greatest number in the computations of steps.h, 2 * P^2 or origin + i *
 * column, is below 2^140. Therefore these computations need no proofs of ranges. The arithmetic is schoolbook
 * arithmetic on 32-bit limbs, the lowest limb first.
 */
#ifndef OST_VALIDATION_DENSE_WIDE_H
#define OST_VALIDATION_DENSE_WIDE_H

#include <stdbool.h>
#include <stdint.h>

enum { WIDE_LIMBS = 8 };
typedef struct wide {
    bool negative; /* true if the integer is negative; always false for 0 */
    uint32_t limb[WIDE_LIMBS];
} wide;

wide wide_of(int64_t v);
wide wide_power_of_two(int n);
wide wide_negated(wide a);
wide wide_plus(wide a, wide b);
wide wide_minus(wide a, wide b);
wide wide_times(wide a, wide b);
/* Returns -1, 0 or 1 if a is less than, equal to or greater than b. */
int wide_order(wide a, wide b);

/* These functions compute AR-INT-1 and AR-INT-2 of the rational number a / b with b > 0. They compute the quotient
   bit by bit, without machine division. */
wide wide_floor(wide a, wide b);
wide wide_nearest(wide a, wide b);

/* If the magnitude is below 2^63, returns the value. If not, returns 0. The ranges of the callers' values guarantee
   that the magnitude is below 2^63. */
int64_t wide_to_int64(wide a);
/* Writes the value as 128-bit two's complement, the low half first. */
void wide_to_words(wide a, uint64_t words[2]);

#endif
