/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/element.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

static const struct {
    const char *name;
    uint8_t bytes;
    bool is_float;
} elements[] = {
    [OST_ELEMENT_NONE] = {"none", 0, false},     [OST_ELEMENT_INT8] = {"int8", 1, false},
    [OST_ELEMENT_UINT8] = {"uint8", 1, false},   [OST_ELEMENT_INT16] = {"int16", 2, false},
    [OST_ELEMENT_UINT16] = {"uint16", 2, false}, [OST_ELEMENT_INT32] = {"int32", 4, false},
    [OST_ELEMENT_UINT32] = {"uint32", 4, false}, [OST_ELEMENT_INT64] = {"int64", 8, false},
    [OST_ELEMENT_UINT64] = {"uint64", 8, false}, [OST_ELEMENT_FLOAT32] = {"float32", 4, true},
    [OST_ELEMENT_FLOAT64] = {"float64", 8, true},
};

static unsigned known(ost_element element)
{
    return (unsigned)element <= OST_ELEMENT_FLOAT64 ? (unsigned)element : OST_ELEMENT_NONE;
}

const char *ost_element_name(ost_element element)
{
    return elements[known(element)].name;
}

size_t ost_element_bytes(ost_element element)
{
    return elements[known(element)].bytes;
}

bool ost_element_is_float(ost_element element)
{
    return elements[known(element)].is_float;
}

/* ------------------------------------------------------- mantissa and exponent */

bool ost_binary_from_double(double value, ost_binary *out)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    int exponent = (int)(bits >> 52 & 0x7ff);
    int64_t mantissa = (int64_t)(bits & ((UINT64_C(1) << 52) - 1));
    if (exponent == 0x7ff)
        return false;
    if (exponent == 0)
        exponent = 1;
    else
        mantissa |= INT64_C(1) << 52;
    out->mantissa = bits >> 63 ? -mantissa : mantissa;
    out->exponent = exponent - 1075;
    return true;
}

static int sign_of(ost_i128 value)
{
    return value < 0 ? -1 : 1;
}

/*
 * Rounds the value half to even. If the result fits into int32, stores it in *out and returns 0. Otherwise, returns
 * the sign of the value.
 */
static int binary_round(ost_binary value, int32_t *out, bool *exact)
{
    if (value.mantissa == 0 || value.exponent < -53) {
        /* |value| < 2^53 * 2^-54 = 1/2 */
        *out = 0;
        *exact = value.mantissa == 0;
        return 0;
    }
    if (value.exponent > 31)
        return sign_of(value.mantissa);
    if (value.exponent >= 0) {
        int64_t limit = INT64_C(1) << (31 - value.exponent);
        if (value.mantissa >= limit || value.mantissa < -limit)
            return sign_of(value.mantissa);
        *out = (int32_t)(value.mantissa * (INT64_C(1) << value.exponent));
        *exact = true;
        return 0;
    }
    int shift = -value.exponent; /* 1..53 */
    int64_t integral = value.mantissa >> shift; /* floor */
    int64_t remainder = value.mantissa & ((INT64_C(1) << shift) - 1);
    int64_t half = INT64_C(1) << (shift - 1);
    integral += remainder > half || (remainder == half && (integral & 1));
    if (integral > INT32_MAX || integral < INT32_MIN)
        return sign_of(integral);
    *out = (int32_t)integral;
    *exact = remainder == 0;
    return 0;
}

/* ----------------------------------------------------------------- scaling */

enum { SCALE_BITS = 78, SCALE_INTEGER = 47 };

/*
 * Computes floor(mantissa * 2^(exponent + 78)). Requires |mantissa| < 2^117. Returns false if |mantissa * 2^exponent|
 * >= 2^47. Results are therefore below 2^125 in magnitude, and the sum of two results is below 2^126.
 */
static bool scale_term(ost_i128 mantissa, int exponent, ost_i128 *out)
{
    int shift = exponent + SCALE_BITS;
    if (mantissa == 0) {
        *out = 0;
        return true;
    }
    if (shift <= 0) {
        *out = mantissa >> (shift < -126 ? 126 : -shift);
    } else {
        if (shift >= SCALE_BITS + SCALE_INTEGER)
            return false;
        ost_i128 limit = (ost_i128)1 << (SCALE_BITS + SCALE_INTEGER - shift);
        if (mantissa >= limit || mantissa <= -limit)
            return false;
        *out = mantissa * ((ost_i128)1 << shift);
    }
    ost_i128 limit = (ost_i128)1 << (SCALE_BITS + SCALE_INTEGER);
    return *out < limit && *out > -limit;
}

/*
 * Computes mantissa * 2^exponent * slope + intercept, rounded half to even, for |mantissa| <= 2^64. If the result fits
 * into int32, stores it in *out and returns 0. Otherwise, returns the sign of the result.
 */
static int scale_value(const ost_converter *c, ost_i128 mantissa, int exponent, int32_t *out, bool *exact)
{
    ost_i128 product, intercept;
    if (!scale_term(mantissa * c->slope.mantissa, exponent + c->slope.exponent, &product))
        return sign_of(mantissa * c->slope.mantissa);
    if (!scale_term(c->intercept.mantissa, c->intercept.exponent, &intercept))
        return sign_of(c->intercept.mantissa);
    ost_i128 sum = product + intercept;
    ost_i128 one = (ost_i128)1 << SCALE_BITS;
    ost_i128 integral = ost_rhe_div128(sum, one);
    if (integral > INT32_MAX || integral < INT32_MIN)
        return sign_of(integral);
    *out = (int32_t)integral;
    *exact = (sum & (one - 1)) == 0;
    return 0;
}

/* ------------------------------------------------------------- the elements */

/* An element after loading. The type of the element determines which field is used. */
typedef struct loaded {
    int64_t integer;
    uint64_t large; /* uint64 elements */
    double value;   /* float elements */
} loaded;

static uint64_t load_bits(const unsigned char *bytes, size_t size, bool swap)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)bytes[i] << 8 * (swap ? size - 1 - i : i);
    return bits;
}

static void load(const ost_converter *c, const unsigned char *bytes, loaded *out)
{
    uint64_t bits = load_bits(bytes, ost_element_bytes(c->element), c->swap);
    uint32_t low = (uint32_t)bits;
    float single;
    out->integer = 0;
    out->large = 0;
    out->value = 0;
    switch (c->element) {
    case OST_ELEMENT_INT8: out->integer = (int8_t)bits; break;
    case OST_ELEMENT_INT16: out->integer = (int16_t)bits; break;
    case OST_ELEMENT_INT32: out->integer = (int32_t)bits; break;
    case OST_ELEMENT_INT64: out->integer = (int64_t)bits; break;
    case OST_ELEMENT_UINT8:
    case OST_ELEMENT_UINT16:
    case OST_ELEMENT_UINT32: out->integer = (int64_t)bits; break;
    case OST_ELEMENT_UINT64: out->large = bits; break;
    case OST_ELEMENT_FLOAT32:
        memcpy(&single, &low, sizeof single);
        out->value = (double)single; /* exact */
        break;
    case OST_ELEMENT_FLOAT64: memcpy(&out->value, &bits, sizeof bits); break;
    case OST_ELEMENT_NONE: assert(false);
    }
}

static void describe(const ost_converter *c, const loaded *l, ost_bad *bad)
{
    if (ost_element_is_float(c->element))
        snprintf(bad->value, sizeof bad->value, "%.9g", l->value);
    else if (c->element == OST_ELEMENT_UINT64)
        snprintf(bad->value, sizeof bad->value, "%llu", (unsigned long long)l->large);
    else
        snprintf(bad->value, sizeof bad->value, "%lld", (long long)l->integer);
}

static size_t convert_general(ost_converter *c, const unsigned char *bytes, size_t count, int16_t *out, ost_bad *bad)
{
    size_t size = ost_element_bytes(c->element);
    for (size_t i = 0; i < count; i++, bytes += size) {
        loaded l;
        ost_binary b = {0, 0};
        int32_t rounded = 0;
        bool exact = true;
        int beyond;
        load(c, bytes, &l);
        if (ost_element_is_float(c->element)) {
            if (!ost_binary_from_double(l.value, &b)) {
                if (c->nan_as_air && l.value != l.value) {
                    out[i] = OST_AIR;
                    c->nan++;
                    continue;
                }
                describe(c, &l, bad);
                bad->kind = l.value != l.value ? OST_BAD_NAN : OST_BAD_INFINITE;
                return i;
            }
            beyond = c->scaled ? scale_value(c, b.mantissa, b.exponent, &rounded, &exact)
                               : binary_round(b, &rounded, &exact);
        } else {
            ost_i128 integer = c->element == OST_ELEMENT_UINT64 ? (ost_i128)l.large : (ost_i128)l.integer;
            if (c->scaled) {
                beyond = scale_value(c, integer, 0, &rounded, &exact);
            } else {
                beyond = integer < INT32_MIN || integer > INT32_MAX ? sign_of(integer) : 0;
                rounded = beyond ? 0 : (int32_t)integer;
            }
        }
        if (!beyond && (rounded < INT16_MIN || rounded > INT16_MAX))
            beyond = sign_of(rounded);
        if (beyond) {
            if (!c->clamp) {
                describe(c, &l, bad);
                bad->kind = OST_BAD_RANGE;
                return i;
            }
            rounded = beyond < 0 ? INT16_MIN : INT16_MAX;
            c->clamped++;
            exact = true;
        }
        c->rounded += !exact;
        out[i] = (int16_t)rounded;
    }
    return count;
}

/*
 * Fast path for the common CT elements, whose values fit into int16 and need no rounding. Returns false for all other
 * elements.
 */
static bool convert_plain(const ost_converter *c, const unsigned char *bytes, size_t count, int16_t *out)
{
    if (c->scaled)
        return false;
    if (c->element == OST_ELEMENT_INT16 && !c->swap) {
        memcpy(out, bytes, count * sizeof *out);
    } else if (c->element == OST_ELEMENT_INT16) {
        for (size_t i = 0; i < count; i++)
            out[i] = (int16_t)(uint16_t)(bytes[2 * i] << 8 | bytes[2 * i + 1]);
    } else if (c->element == OST_ELEMENT_UINT8) {
        for (size_t i = 0; i < count; i++)
            out[i] = bytes[i];
    } else if (c->element == OST_ELEMENT_INT8) {
        for (size_t i = 0; i < count; i++)
            out[i] = (int8_t)bytes[i];
    } else {
        return false;
    }
    return true;
}

/*
 * Fast path for a CT that was stored as float32 although its values are integers. Stops at the first element that is
 * not an integer in the range of int16, and returns the number of converted elements. The conversions between float and
 * integer are exact, so no rounding mode affects them.
 */
static size_t convert_integral(const ost_converter *c, const unsigned char *bytes, size_t count, int16_t *out)
{
    if (c->element != OST_ELEMENT_FLOAT32 || c->swap || c->scaled)
        return 0;
    for (size_t i = 0; i < count; i++) {
        float value;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        if (!(value >= INT16_MIN && value <= INT16_MAX) || (float)(int32_t)value != value)
            return i;
        out[i] = (int16_t)value;
    }
    return count;
}

size_t ost_convert(ost_converter *converter, const void *bytes, size_t count, int16_t *out, ost_bad *bad)
{
    bad->kind = OST_BAD_NONE;
    bad->value[0] = 0;
    if (convert_plain(converter, bytes, count, out))
        return count;
    const size_t done = convert_integral(converter, bytes, count, out), size = ost_element_bytes(converter->element);
    return done + convert_general(converter, (const unsigned char *)bytes + done * size, count - done, out + done, bad);
}
