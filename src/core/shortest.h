/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shortest decimal that reads back as a given float or double.  By definition, a
 * binary number in a file represents this decimal (AR-LEN-4).
 */
#ifndef OST_CORE_SHORTEST_H
#define OST_CORE_SHORTEST_H

#include <osteon/length.h>

/*
 * Finds the decimal that a float represents: the shortest decimal that reads back as the float. There is one
 * exception. A float32 represents its exact value if two conditions hold: its value is a multiple of 2^-9 and below
 * 2^24 in magnitude, and no decimal of at most six digits reads back as this float32. For example, 431/512 represents
 * 0.841796875, not 0.8417969.
 *
 * `value` must be finite. `single` is true if `value` was read as a float32. Returns false if the exponent is out of
 * the range of ost_decimal.
 */
bool ost_decimal_shortest(double value, bool single, ost_decimal *out);

/*
 * In a number printed by %e, replaces the locale's decimal separator, which may have several bytes, with a point:
 * "1,5e+00" becomes "1.5e+00".
 */
void ost_point_put_back(char *text);

#endif
