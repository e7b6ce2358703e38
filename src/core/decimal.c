/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decimals as they are written (docs/arithmetic.md, AR-LEN-2).
 *
 *   "-57.3400e1"  ->  mantissa -573400, exponent -3, places 3
 *
 * Up to 18 significant digits are kept in the mantissa (10^18 < 2^63); what
 * follows only shifts the exponent, and marks the value inexact when it is
 * not all zeros: then the value stands for the mantissa and a positive
 * infinitesimal more in magnitude, which can break a tie and nothing else.
 * Leading zeros cost no digit, trailing ones after the point keep `places`
 * as written.
 *
 * Scaling divides once, exactly, in 128 bits:
 *   |mantissa| < 10^18 < 2^60, factor < 2^64: the product is below 2^124.
 */
#include "core/conditions.h"

#include <osteon/length.h>

#include "core/integer.h"

enum { MANTISSA_DIGITS = 18, EXPONENT_MAX = 9999 };

static bool is_digit(const char *p, const char *end)
{
    return p < end && *p >= '0' && *p <= '9';
}

/* Reads e[+-]digits at p into *exponent; returns the byte after it, p when there is none, NULL when it is too great. */
static const char *read_exponent(const char *p, const char *end, int32_t *exponent)
{
    *exponent = 0;
    if (p >= end || (*p != 'e' && *p != 'E'))
        return p;
    const char *q = p + 1;
    bool negative = q < end && *q == '-';
    if (q < end && (*q == '-' || *q == '+'))
        q++;
    if (!is_digit(q, end))
        return p;
    int32_t value = 0;
    for (; is_digit(q, end); q++) {
        value = value * 10 + (*q - '0');
        if (value > EXPONENT_MAX)
            return NULL;
    }
    *exponent = negative ? -value : value;
    return q;
}

const char *ost_decimal_read(const char *text, const char *end, ost_decimal *out)
{
    const char *p = text;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+'))
        p++;

    int64_t mantissa = 0;
    int digits = 0;       /* significant digits in mantissa */
    int64_t exponent = 0; /* of the mantissa's last digit, before the written exponent */
    int64_t places = 0;
    bool inexact = false;
    bool any = false;
    bool after_point = false;
    for (;; p++) {
        if (!after_point && p < end && *p == '.') {
            after_point = true;
            continue;
        }
        if (!is_digit(p, end))
            break;
        int digit = *p - '0';
        any = true;
        places += after_point;
        if (digits < MANTISSA_DIGITS) {
            mantissa = mantissa * 10 + digit;
            digits += mantissa != 0;
            exponent -= after_point;
        } else {
            inexact |= digit != 0;
            exponent += !after_point;
        }
    }
    if (!any)
        return NULL;
    int32_t written;
    p = read_exponent(p, end, &written);
    if (!p)
        return NULL;
    /* A text of 2^31 digits cannot come: readers bound their lines. Saturate all the same. */
    if (exponent > INT32_MAX / 2)
        exponent = INT32_MAX / 2;
    if (exponent < INT32_MIN / 2)
        exponent = INT32_MIN / 2;
    if (places > INT32_MAX / 2)
        places = INT32_MAX / 2;
    *out = (ost_decimal){
        .mantissa = negative ? -mantissa : mantissa,
        .exponent = (int32_t)exponent + written,
        .places = (int32_t)places - written,
        .inexact = inexact,
        .negative = negative,
    };
    return p;
}

/* RHE of (product + e) / 10^power, e a positive infinitesimal when sticky (AR-LEN-2), else 0. */
static ost_i128 divide_by_ten_to(ost_i128 product, int power, bool sticky, bool *exact)
{
    ost_i128 divisor = 1;
    for (int i = 0; i < power; i++)
        divisor *= 10;
    ost_i128 quotient = product / divisor;
    ost_i128 rest = product % divisor;
    *exact = rest == 0 && !sticky;
    ost_i128 other = divisor - rest;
    bool up = rest > other || (rest == other && (sticky || (quotient & 1)));
    return quotient + up;
}

bool ost_decimal_scale(const ost_decimal *value, uint64_t factor, int64_t *out, bool *exact)
{
    bool rounded_none;
    bool negative = value->mantissa < 0;
    ost_i128 product = negative ? -(ost_i128)value->mantissa : value->mantissa;
    product *= factor;
    ost_i128 result;
    if (product == 0 && !value->inexact) {
        result = 0;
        rounded_none = true;
    } else if (value->exponent >= 0) {
        result = product;
        for (int32_t i = 0; i < value->exponent; i++) {
            if (result > INT64_MAX)
                return false;
            result *= 10;
        }
        rounded_none = !value->inexact;
    } else if (value->exponent < -37) {
        /* product < 2^124 < 10^37.4, and 10^38 / 2 is greater: it rounds to 0. */
        result = 0;
        rounded_none = false;
    } else {
        result = divide_by_ten_to(product, -value->exponent, value->inexact, &rounded_none);
    }
    if (result > INT64_MAX)
        return false;
    *out = negative ? -(int64_t)result : (int64_t)result;
    if (exact)
        *exact = rounded_none;
    return true;
}
