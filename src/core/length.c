/* SPDX-License-Identifier: Apache-2.0 */
/* Converts decimal numbers and floats to picometres, and picometres to text (AR-LEN). */
#include "core/conditions.h"

#include <osteon/length.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/integer.h"
#include "core/shortest.h"

void ost_pm3_widen(ost_pm3 *lo, ost_pm3 *hi, ost_pm3 p)
{
    lo->x = p.x < lo->x ? p.x : lo->x;
    lo->y = p.y < lo->y ? p.y : lo->y;
    lo->z = p.z < lo->z ? p.z : lo->z;
    hi->x = p.x > hi->x ? p.x : hi->x;
    hi->y = p.y > hi->y ? p.y : hi->y;
    hi->z = p.z > hi->z ? p.z : hi->z;
}

bool ost_decimal_to_pm(const ost_decimal *value, ost_pm *out, bool *exact)
{
    return ost_decimal_scale(value, (uint64_t)OST_PM_PER_MM, out, exact) && *out >= -OST_LENGTH_MAX &&
           *out <= OST_LENGTH_MAX;
}

ost_status ost_pm_parse(const char *text, ost_pm *out, ost_error *err)
{
    const char *end = text + strlen(text);
    ost_decimal decimal;
    if (end == text || ost_decimal_read(text, end, &decimal) != end)
        return ost_fail(err, OST_ERR_INPUT,
                        "'%.80s' is not a length; expected a decimal number of millimetres, for example 0.47", text);
    if (!ost_decimal_to_pm(&decimal, out, NULL))
        return ost_fail(err, OST_ERR_RANGE, "%.80s mm; expected at most 8000 mm", text);
    return OST_OK;
}

static bool from_shortest(double value, bool single, ost_pm *out)
{
    ost_decimal decimal;
    return ost_decimal_shortest(value, single, &decimal) && ost_decimal_to_pm(&decimal, out, NULL);
}

bool ost_pm_from_float(float mm, ost_pm *out)
{
    return isfinite(mm) && from_shortest((double)mm, true, out);
}

bool ost_pm_from_double(double mm, ost_pm *out)
{
    return isfinite(mm) && from_shortest(mm, false, out);
}

/*
 * Let mm = m * 2^e with |m| < 2^53, so |m * 10^9| < 2^83.  Because |mm| <= 8000 < 2^13,
 * e <= 13 - 53 = -40.  The product is therefore always shifted right, by -e, and rounded
 * half to even.
 */
bool ost_pm_from_binary(double mm, ost_pm *out)
{
    if (!isfinite(mm) || mm > 8000.0 || mm < -8000.0)
        return false;
    int exponent;
    double fraction = frexp(mm, &exponent); /* frexp is exact: mm = fraction 2^exponent with 0.5 <= |fraction| < 1 */
    ost_i128 scaled = (ost_i128)(int64_t)ldexp(fraction, 53) * OST_PM_PER_MM;
    int shift = 53 - exponent; /* at least 40, because exponent is at most 13 */
    *out = shift > 120 ? 0 : (ost_pm)ost_rhe_div128(scaled, (ost_i128)1 << shift);
    return true;
}

char *ost_pm_format(ost_pm value, char text[OST_PM_TEXT])
{
    uint64_t magnitude = value < 0 ? -(uint64_t)value : (uint64_t)value;
    uint64_t integer = magnitude / (uint64_t)OST_PM_PER_MM;
    uint64_t remainder = magnitude % (uint64_t)OST_PM_PER_MM;
    int length = snprintf(text, OST_PM_TEXT, "%s%" PRIu64 ".%09" PRIu64, value < 0 ? "-" : "", integer, remainder);
    while (text[length - 1] == '0')
        text[--length] = 0;
    if (text[length - 1] == '.')
        text[--length] = 0;
    return text;
}

double ost_pm_to_mm(ost_pm value)
{
    return (double)value / (double)OST_PM_PER_MM;
}
