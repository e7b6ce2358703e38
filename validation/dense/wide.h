/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 256-bit integers as sign and magnitude. All numbers in the computations of steps.h are below 2^140 (the greatest
 * are 2 * P^2 and origin + i * column), so these computations need no proofs of ranges. The arithmetic is schoolbook
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

/* These functions return floor(a / b) (AR-INT-1) and RHE(a / b) (AR-INT-2), for b > 0. They compute the quotient
   bit by bit, without machine division. */
wide wide_floor(wide a, wide b);
wide wide_nearest(wide a, wide b);

/* Returns the value, or 0 if its magnitude is not below 2^63. The ranges of the callers' values exclude this case. */
int64_t wide_to_int64(wide a);
/* Writes the value as 128-bit two's complement, the low half first. */
void wide_to_words(wide a, uint64_t words[2]);

#endif
