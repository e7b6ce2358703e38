/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A density of the common form, [-]digits with 1 to 5 digits and a value
 * within int16.  Eight bytes that end with the last digit hold all of it:
 *
 *   bytes    3 0 0 0 ' ' - 1 0 4 3      w = the last eight, the first in the lowest byte
 *   w ^ '0'  ... 1 0 4 3 in the highest bytes; the others are masked away
 *
 * A byte b is a digit iff b < 10, iff neither b nor b + 6 reaches 16.  (A
 * carry out of a byte needs b >= 250, which the first test has seen.)
 */
#ifndef OST_IO_TEXT_DENSITY_H
#define OST_IO_TEXT_DENSITY_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* [q, end) as a density; false when it is not of the common form. Eight bytes before end can be read. */
static inline bool ost_text_density(const char *q, const char *end, int16_t *density)
{
    int64_t length = end - q;
    if (length < 1 || length > 6)
        return false;
    int64_t negative = *q == '-', digits = length - negative;
    if (digits < 1 || digits > 5)
        return false;
    uint64_t t;
    memcpy(&t, end - 8, sizeof t);
    t = (t ^ UINT64_C(0x3030303030303030)) & (UINT64_MAX << (64 - 8 * digits));
    if (((t + UINT64_C(0x0606060606060606)) | t) & UINT64_C(0xf0f0f0f0f0f0f0f0))
        return false;
    /* Pairs, fours, the eight of them: each product's upper half is the sum wanted. */
    t = (t * 2561) >> 8 & UINT64_C(0x00ff00ff00ff00ff);
    t = (t * 6553601) >> 16 & UINT64_C(0x0000ffff0000ffff);
    t = (t * UINT64_C(42949672960001)) >> 32;
    if ((int64_t)t > INT16_MAX + negative)
        return false;
    *density = (int16_t)(negative ? -(int64_t)t : (int64_t)t);
    return true;
}

#endif
