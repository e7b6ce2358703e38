/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shortest decimal that reads back as a given float or double, which is the
 * value that a file's binary number represents (AR-LEN-4).
 */
#ifndef OST_CORE_SHORTEST_H
#define OST_CORE_SHORTEST_H

#include <osteon/length.h>

/*
 * Finds the decimal that a float represents. If no decimal of at most six digits
 * reads back as a float32, and the float32 is a multiple of 2^-9 below 2^24 in
 * magnitude, like 431/512, it represents itself: 0.841796875, not 0.8417969.
 * value is finite; single is true if it came from a float32. Returns false if the
 * exponent is out of the range of ost_decimal.
 */
bool ost_decimal_shortest(double value, bool single, ost_decimal *out);

/*
 * Replaces the locale's decimal separator, one byte or several, in a number printed by %e: "1,5e+00"
 * becomes "1.5e+00".
 */
void ost_point_put_back(char *text);

#endif
