/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Asserts the properties of the compiler and the machine on which the arithmetic
 * depends (docs/spec/arithmetic.md section 2).  Included by every source whose results
 * affect voxels.
 */
#ifndef OST_CORE_CONDITIONS_H
#define OST_CORE_CONDITIONS_H

#include <float.h>
#include <limits.h>
#include <stdint.h>

#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__ > 0)
#error "fast-math breaks the arithmetic"
#endif
#if !defined __BYTE_ORDER__ || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "a little-endian machine is needed"
#endif

_Static_assert(CHAR_BIT == 8, "8-bit bytes");
_Static_assert(FLT_EVAL_METHOD == 0, "no excess precision");
_Static_assert((-3 >> 1) == -2, "arithmetic right shift");
_Static_assert(sizeof(__int128) == 16, "128-bit integers");

#endif
