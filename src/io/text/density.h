/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parses a density of the common form: an optional minus sign and 1 to 5 digits, with a value within int16. The word w
 * contains the next eight bytes of the text; the first of them is the lowest byte of w. The density has n bytes.
 *
 *   bytes    1 0 4 3 \n - 5 7       x = w ^ "\n\n\n\n\n\n\n\n"
 *   The first newline is the first zero byte of x. The lowest set bit of
 *   (x - 01..01) & ~x & 80..80 lies in this byte.  (A borrow sets bits only in higher bytes.)
 *
 *   w << 8 (8 - n)   . . . . 1 0 4 3     the last digit moves to the highest byte
 *   ^ '0'            digits become 0 to 9; the bytes below the digits are masked off
 *
 * A byte b is a digit iff b < 10. This is equivalent to b < 16 and b + 6 < 16. (The sum carries into the next byte only
 * if b >= 250; such a byte fails the first test.)
 */
#ifndef OST_IO_TEXT_DENSITY_H
#define OST_IO_TEXT_DENSITY_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static inline uint64_t ost_text_word(const char *p)
{
    uint64_t w;
    memcpy(&w, p, sizeof w);
    return w;
}

/* Returns the number of bytes in w before the first newline; 8 if w contains no newline. */
static inline int64_t ost_text_bytes_of_line(uint64_t w)
{
    uint64_t x = w ^ UINT64_C(0x0a0a0a0a0a0a0a0a);
    uint64_t zero = (x - UINT64_C(0x0101010101010101)) & ~x & UINT64_C(0x8080808080808080);
    return zero ? __builtin_ctzll(zero) / 8 : 8;
}

/*
 * Parses the first `length` of the eight bytes in w as a density. Returns false if the density is not of the common
 * form.
 */
static inline bool ost_text_density(uint64_t w, int64_t length, int16_t *density)
{
    if (length < 1 || length > 6)
        return false;
    int64_t negative = (w & 0xff) == '-', digits = length - negative;
    if (digits < 1 || digits > 5)
        return false;
    uint64_t t = w << (64 - 8 * length);
    t = (t ^ UINT64_C(0x3030303030303030)) & (UINT64_MAX << (64 - 8 * digits));
    if (((t + UINT64_C(0x0606060606060606)) | t) & UINT64_C(0xf0f0f0f0f0f0f0f0))
        return false;
    /*
     * Combines digits into pairs, pairs into groups of four, and the two groups into one number. Each multiplication
     * leaves its results in the upper halves of the lanes.
     */
    t = (t * 2561) >> 8 & UINT64_C(0x00ff00ff00ff00ff);
    t = (t * 6553601) >> 16 & UINT64_C(0x0000ffff0000ffff);
    t = (t * UINT64_C(42949672960001)) >> 32;
    if ((int64_t)t > INT16_MAX + negative)
        return false;
    *density = (int16_t)(negative ? -(int64_t)t : (int64_t)t);
    return true;
}

#endif
