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

bool ost_decimal_shortest(double value, bool single, ost_decimal *out)
{
    char text[64]; /* sign, 17 digits, a point of a few bytes, e-308 */
    const int most = single ? 9 : 17;
    for (int digits = 1; digits <= most; digits++) {
        snprintf(text, sizeof text, "%.*e", digits - 1, value);
        if (single ? strtof(text, NULL) == (float)value : strtod(text, NULL) == value)
            break;
    }
    ost_point_put_back(text);
    const char *end = text + strlen(text);
    return ost_decimal_read(text, end, out) == end;
}
