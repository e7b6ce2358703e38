/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and scales decimals exactly as written (docs/spec/arithmetic.md, AR-LEN-2).
 *
 *   "-57.3400e1"  ->  mantissa -573400, tail 0, exponent -3, places 3
 *
 * The first 18 significant digits form the mantissa. The next 18 digits form the tail, whose unit is 10^-18 of the
 * mantissa's last digit. A tail that consists of the single digit 5 has the value 5 * 10^17.  Any later digit that is
 * not 0 sets `more`.  Leading zeros are not significant; trailing zeros after the point are counted in `places`.
 *
 * Scaling divides once, exactly, in 128 bits.  With e = -exponent >= 0:
 *
 *   tail * factor = a * 10^18 + b                     a < 2^64, b < 10^18
 *   value * factor * 10^e = (|mantissa| * factor + a) + (b + more) / 10^18
 *   |mantissa| * factor + a = q * 10^e + r              < 2^60 * 2^64 + 2^64 < 2^125
 *
 * q is the floor.  q is rounded up if r is greater than 10^e / 2.  If r equals 10^e / 2, b and `more` determine whether
 * q is rounded up.
 */
#include "core/conditions.h"

#include <osteon/length.h>

#include "core/integer.h"

enum { PART_DIGITS = 18, EXPONENT_MAX = 9999 };
#define TEN_TO_18 INT64_C(1000000000000000000)

static bool is_digit(const char *p, const char *end)
{
    return p < end && *p >= '0' && *p <= '9';
}

/*
 * Reads e[+-]digits at p into *exponent. Returns a pointer to the byte after the exponent, p if there is no exponent,
 * or NULL if the magnitude of the exponent is too large.
 */
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

/*
 * Limits a count of digits to half of the range of int32. A value with so many digits is out of range in any case.
 * Counts from files are far smaller, because readers limit the length of lines.
 */
static int32_t saturated(int64_t count)
{
    return (int32_t)(count > INT32_MAX / 2 ? INT32_MAX / 2 : count < INT32_MIN / 2 ? INT32_MIN / 2 : count);
}

const char *ost_decimal_read(const char *text, const char *end, ost_decimal *out)
{
    const char *p = text;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+'))
        p++;

    ost_decimal d = {.negative = negative};
    int mantissa_digits = 0;
    int64_t tail_unit = TEN_TO_18; /* weight of the digit that was last added to the tail */
    int64_t exponent = 0;
    int64_t places = 0;
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
        if (mantissa_digits < PART_DIGITS) {
            d.mantissa = d.mantissa * 10 + digit;
            mantissa_digits += d.mantissa != 0;
            exponent -= after_point;
            continue;
        }
        exponent += !after_point;
        tail_unit /= 10; /* 0 after 18 digits */
        d.tail += tail_unit * digit;
        d.more |= tail_unit == 0 && digit != 0;
    }
    int32_t written = 0;
    if (!any || !(p = read_exponent(p, end, &written)))
        return NULL;
    d.inexact = d.tail != 0 || d.more;
    d.mantissa = negative ? -d.mantissa : d.mantissa;
    d.exponent = saturated(exponent) + written;
    d.places = saturated(places) - written;
    *out = d;
    return p;
}

/*
 * Returns true if RHE rounds the quotient up. The fractional part of the quotient is (remainder + beyond * 10^-18) /
 * ten_to_e. If `more` is true, the fractional part is slightly greater, by less than 10^-18 / ten_to_e.
 */
static bool rounds_up(ost_i128 quotient, ost_i128 remainder, ost_i128 ten_to_e, int64_t beyond, bool more)
{
    bool something = beyond > 0 || more;
    if (ten_to_e == 1) {
        if (beyond != TEN_TO_18 / 2)
            return beyond > TEN_TO_18 / 2;
        something = more;
    } else if (remainder != ten_to_e / 2) {
        return remainder > ten_to_e / 2;
    }
    return something || (quotient & 1);
}

bool ost_decimal_scale(const ost_decimal *value, uint64_t factor, int64_t *out, bool *exact)
{
    ost_i128 tail = (ost_i128)value->tail * factor;
    bool negative = value->mantissa < 0;
    ost_i128 integer = (negative ? -(ost_i128)value->mantissa : value->mantissa) * factor + tail / TEN_TO_18;
    int64_t beyond = (int64_t)(tail % TEN_TO_18);
    bool none_rounded = beyond == 0 && !value->more;

    /*
     * Each step moves one digit of the tail to `integer`. If the tail is not 0, the mantissa has 18 digits, so
     * `integer` exceeds int64 after at most two steps and the function returns.
     */
    for (int32_t e = value->exponent; e > 0 && (integer || beyond); e--) {
        if (integer > INT64_MAX)
            return false;
        ost_i128 shifted = (ost_i128)beyond * 10;
        integer = integer * 10 + shifted / TEN_TO_18;
        beyond = (int64_t)(shifted % TEN_TO_18);
        none_rounded = beyond == 0 && !value->more;
    }

    ost_i128 ten_to_e = 1;
    int32_t e = value->exponent < 0 ? -value->exponent : 0;
    if (e > 37) { /* 10^e is more than twice the integer, which is below 2^125, so the quotient rounds to 0 */
        none_rounded = none_rounded && integer == 0;
        integer = 0;
    } else {
        for (int32_t i = 0; i < e; i++)
            ten_to_e *= 10;
        ost_i128 quotient = integer / ten_to_e;
        ost_i128 remainder = integer % ten_to_e;
        none_rounded = none_rounded && remainder == 0;
        integer = quotient + rounds_up(quotient, remainder, ten_to_e, beyond, value->more);
    }
    if (integer > INT64_MAX)
        return false;
    *out = negative ? -(int64_t)integer : (int64_t)integer;
    if (exact)
        *exact = none_rounded;
    return true;
}

/* All digits of an integer below 2^64 < 10^20 are in the mantissa and the first two digits of the tail. */
bool ost_decimal_integer(const ost_decimal *value, uint64_t *magnitude)
{
    /* digits < 10^36 */
    ost_i128 digits = (ost_i128)(value->mantissa < 0 ? -value->mantissa : value->mantissa) * TEN_TO_18 + value->tail;
    int32_t exponent = value->exponent - PART_DIGITS;
    if (value->more)
        return false;
    while (exponent < 0 && digits % 10 == 0 && digits > 0) {
        digits /= 10;
        exponent++;
    }
    for (; exponent > 0 && digits > 0 && digits <= UINT64_MAX; exponent--)
        digits *= 10;
    if (digits == 0)
        exponent = 0;
    *magnitude = (uint64_t)digits;
    return exponent == 0 && digits <= UINT64_MAX;
}
