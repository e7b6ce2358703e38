/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the shortest decimal of a number.  The number is printed with more and more digits by
 * correctly rounding C functions, and each text is read back, until the result equals the original
 * number. 9 digits suffice for any float, and 17 for any double.  Printing and reading both use the
 * program's locale.  Afterwards, the locale's decimal separator is replaced by a point, and the
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
        return; /* A number with a single digit contains no decimal separator. */
    *point = '.';
    memmove(point + 1, point + length, strlen(point + length) + 1);
}

/* Returns true if 512 v is an integer and |v| < 2^24. In decimal, such a number v has at most 8 digits before the
   point and 9 digits after it. */
static bool is_ninth_binary_place(double v)
{
    return v > -16777216.0 && v < 16777216.0 && (double)(int64_t)(v * 512) == v * 512;
}

bool ost_decimal_shortest(double value, bool single, ost_decimal *out)
{
    /* no two decimals with at most six significant digits read as the same float32 */
    enum { MAX_DIGITS_TRIED = 6 };
    char text[64];     /* sign, 17 digits, a separator of a few bytes, "e-308" and NUL */
    const int most = single ? 9 : 17;
    for (int digits = 1; digits <= most; digits++) {
        if (single && digits > MAX_DIGITS_TRIED && is_ninth_binary_place(value)) {
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
