/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact lengths as int64 picometres (docs/spec/arithmetic.md, AR-LEN).
 *
 *   1 mm = 1,000,000,000 pm, so 0.48828125 mm and every decimal in mm with up
 *   to nine places is exact.  |length| <= OST_LENGTH_MAX (8 m).
 *
 * Decimals are read from text exactly. A float from a file represents the shortest decimal that reads back as this
 * float. Except for ost_pm_to_mm, no result in this header depends on floating-point rounding or on the locale.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_LENGTH_H
#define OSTEON_LENGTH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define OST_PM_PER_MM INT64_C(1000000000)
#define OST_LENGTH_MAX (INT64_C(8000) * OST_PM_PER_MM)

typedef int64_t ost_pm;

/* A point or a vector in picometres. */
typedef struct ost_pm3 {
    ost_pm x, y, z;
} ost_pm3;

/* Widens the bounds [*lo, *hi] so that they contain p. */
OST_API void ost_pm3_widen(ost_pm3 *lo, ost_pm3 *hi, ost_pm3 p);

/*
 * A decimal as written in a string:
 *
 *   value = +-(|mantissa| + tail / 10^18) * 10^exponent
 *
 * `mantissa` contains the sign and the first 18 significant digits, and `tail` contains the next 18. `inexact` is true
 * if the tail or a later digit is not 0; `more` is true if a digit after the tail is not 0. The last digit written has
 * the unit 10^-places. For example, `places` is 2 for 1.250e1, and -3 for 12e3.
 *
 * 36 digits suffice for every rounding here (AR-LEN-2). A tie is a value for which value * 10^9 or value * 2^30 is
 * exactly between two integers. A tie has at most 31 digits after the point. If the first 36 digits of a value are
 * those of a tie, the other digits can only make the value greater than the tie.
 */
typedef struct ost_decimal {
    int64_t mantissa; /* |mantissa| < 10^18 */
    int64_t tail;     /* 0 <= tail < 10^18 */
    int32_t exponent;
    int32_t places;
    bool inexact;
    bool more;
    bool negative; /* true if a minus sign was written, which distinguishes -0 from 0 */
} ost_decimal;

/*
 * Reads the longest decimal ([+-]digits[.digits][(e|E)[+-]digits]) at the start
 * of [text, end). Returns a pointer to the first byte after the decimal, or NULL if
 * there is no decimal ("nan", "inf" and empty text are not decimals) or if the
 * magnitude of the written exponent exceeds 9,999.
 */
OST_API const char *ost_decimal_read(const char *text, const char *end, ost_decimal *out);

/*
 * Computes value * factor, rounded half to even, for factor >= 1. The rounding is correct for decimals of up to 36
 * significant digits. It is correct for any number of digits if the factor is a product of powers of 2 and 10 and no
 * tie has more than 36 digits. A tie is a value for which the product is exactly between two integers. Returns false if
 * the result does not fit in an int64. If exact is not NULL, sets *exact to true if nothing was rounded, and to false
 * otherwise.
 */
OST_API bool ost_decimal_scale(const ost_decimal *value, uint64_t factor, int64_t *out, bool *exact);

/*
 * Returns true if the value is an integer with a magnitude below 2^64, and writes the magnitude to *magnitude. The
 * sign of the value is value->negative.
 */
OST_API bool ost_decimal_integer(const ost_decimal *value, uint64_t *magnitude);

/*
 * Converts a decimal in millimetres to picometres, rounded half to even. Returns false if the length is outside
 * +-OST_LENGTH_MAX.
 */
OST_API bool ost_decimal_to_pm(const ost_decimal *value, ost_pm *out, bool *exact);

/*
 * Converts a string such as "0.47", in millimetres, to picometres. Returns OST_ERR_INPUT unless the string is exactly
 * one decimal, and OST_ERR_RANGE if the length is outside +-OST_LENGTH_MAX.
 */
OST_API ost_status ost_pm_parse(const char *text, ost_pm *out, ost_error *err);

/*
 * Converts a float32 in millimetres to picometres. The shortest decimal that reads back as this float32 is rounded
 * half to even. Returns false if the number is NaN, infinite or out of range.
 */
OST_API bool ost_pm_from_float(float mm, ost_pm *out);
/* Converts a float64 in millimetres to picometres by the rule of ost_pm_from_float. */
OST_API bool ost_pm_from_double(double mm, ost_pm *out);

/*
 * Converts a number in millimetres to picometres. The exact binary value of the number is rounded half to even.
 * Used for mesh vertices (AR-MESH-2). Returns false if the number is NaN, infinite or out of range.
 */
OST_API bool ost_pm_from_binary(double mm, ost_pm *out);

enum { OST_PM_TEXT = 32 };
/*
 * Formats a length in millimetres as the shortest exact decimal, for example "0.47", "-57.34" or "1", with
 * at most nine places. Returns text.
 */
OST_API char *ost_pm_format(ost_pm value, char text[OST_PM_TEXT]);
/* Returns a length in millimetres, rounded to the nearest double. Used only for display and pictures. */
OST_API double ost_pm_to_mm(ost_pm value);

#ifdef __cplusplus
}
#endif
#endif
