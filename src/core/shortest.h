/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shortest decimal that reads back as a float or a double: what a file's
 * binary number stands for (AR-LEN-4).
 */
#ifndef OST_CORE_SHORTEST_H
#define OST_CORE_SHORTEST_H

#include <osteon/length.h>

/*
 * Finds the decimal that a float stands for. A float32 of which no decimal of
 * six digits reads back and that is a multiple of 2^-9, like 431/512, stands
 * for itself: 0.841796875 and not 0.8417969.
 * value is finite; single: it came from a float. False when its exponent is beyond what a decimal may have.
 */
bool ost_decimal_shortest(double value, bool single, ost_decimal *out);

/* "1,5e+00" to "1.5e+00": a number as printf's %e prints it, whatever the locale has between its digits, a comma or more bytes. */
void ost_point_put_back(char *text);

#endif
