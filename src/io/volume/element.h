/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the elements of a volume file to int16 densities.
 *
 *   integers    unchanged; values outside int16 are an error, or are clamped if the options allow it
 *   floats      rounded half to even to an integer, then as above; infinity is
 *               always an error; NaN is an error unless the options define it as air
 *   scaled      (NIfTI) value * slope + intercept: each of the two terms is
 *               computed from the exact binary numbers and rounded down to a
 *               multiple of 2^-78 (exact whenever slope and intercept are
 *               float32 of at least 2^-54); the sum is rounded half to even
 *
 * All computations use integers: a float is split into mantissa and exponent, so no rounding mode, compiler or machine
 * can change a density.
 */
#ifndef OST_IO_ELEMENT_H
#define OST_IO_ELEMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum ost_element {
    OST_ELEMENT_NONE,
    OST_ELEMENT_INT8,
    OST_ELEMENT_UINT8,
    OST_ELEMENT_INT16,
    OST_ELEMENT_UINT16,
    OST_ELEMENT_INT32,
    OST_ELEMENT_UINT32,
    OST_ELEMENT_INT64,
    OST_ELEMENT_UINT64,
    OST_ELEMENT_FLOAT32,
    OST_ELEMENT_FLOAT64
} ost_element;

const char *ost_element_name(ost_element element); /* for example "int16"; never NULL */
size_t ost_element_bytes(ost_element element);
bool ost_element_is_float(ost_element element);

/* The number mantissa * 2^exponent, with |mantissa| < 2^53. */
typedef struct ost_binary {
    int64_t mantissa;
    int32_t exponent;
} ost_binary;

/* Splits a finite number into mantissa and exponent. Returns false for NaN and infinity. */
bool ost_binary_from_double(double value, ost_binary *out);

enum { OST_AIR = -1024 }; /* density, in HU, to which NaN is converted if the options permit NaN */

typedef struct ost_converter {
    ost_element element;
    bool swap;  /* true if the bytes in the file are big-endian */
    bool clamp; /* if true, values outside int16 are clamped; if false, they are errors */
    bool nan_as_air; /* if true, NaN is converted to OST_AIR, even if values are scaled; if false, it is an error */
    bool scaled;
    ost_binary slope, intercept;
    uint64_t rounded, clamped, nan; /* counts of the values that ost_convert rounded, clamped or found to be NaN */
} ost_converter;

typedef enum ost_bad_kind { OST_BAD_NONE, OST_BAD_NAN, OST_BAD_INFINITE, OST_BAD_RANGE } ost_bad_kind;
typedef struct ost_bad {
    ost_bad_kind kind;
    char value[32]; /* text of the value, for messages */
} ost_bad;

/*
 * Converts `count` elements, but stops at the first one that cannot be converted. Returns the number of converted
 * elements. If it is less than `count`, *bad describes the element that cannot be converted.
 */
size_t ost_convert(ost_converter *converter, const void *bytes, size_t count, int16_t *out, ost_bad *bad);

#endif
