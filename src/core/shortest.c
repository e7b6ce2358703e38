/* SPDX-License-Identifier: Apache-2.0 */
/*
 * C's own printing and reading of correctly rounded decimals, tried with more
 * and more digits: 9 say any float, 17 any double.  Both go by the program's
 * locale, which is the same for both; then the point is put back and the
 * decimal is read exactly.
 */
#include "core/shortest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ost_point_put_back(char *text)
{
    char *point = text + strspn(text, "-0123456789");
    const size_t length = strcspn(point, "0123456789e");
    if (length == 0)
        return; /* one digit alone has none */
    *point = '.';
    memmove(point + 1, point + length, strlen(point + length) + 1);
}

/* 512 v is an integer, and |v| < 2^24: then v is a decimal of at most 8 + 9 digits. */
static bool is_ninth_binary_place(double v)
{
    return v > -16777216.0 && v < 16777216.0 && (double)(int64_t)(v * 512) == v * 512;
}

bool ost_decimal_shortest(double value, bool single, ost_decimal *out)
{
    enum { NICE = 6 }; /* digits that every float32 can tell apart */
    char text[64];     /* sign, 17 digits, a point of a few bytes, e-308 */
    const int most = single ? 9 : 17;
    for (int digits = 1; digits <= most; digits++) {
        if (single && digits > NICE && is_ninth_binary_place(value)) {
            snprintf(text, sizeof text, "%.16e", value);
            break;
        }
        snprintf(text, sizeof text, "%.*e", digits - 1, value);
        if (single ? strtof(text, NULL) == (float)value : strtod(text, NULL) == value)
            break;
    }
    ost_point_put_back(text);
    const char *end = text + strlen(text);
    return ost_decimal_read(text, end, out) == end;
}
