/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dense/wide.h"

static int magnitude_order(const wide *a, const wide *b)
{
    for (int i = WIDE_LIMBS - 1; i >= 0; i--)
        if (a->limb[i] != b->limb[i])
            return a->limb[i] < b->limb[i] ? -1 : 1;
    return 0;
}

static bool is_zero(const wide *a)
{
    for (int i = 0; i < WIDE_LIMBS; i++)
        if (a->limb[i])
            return false;
    return true;
}

wide wide_of(int64_t v)
{
    const uint64_t magnitude = v < 0 ? 0 - (uint64_t)v : (uint64_t)v;
    wide out = {.negative = v < 0, .limb = {(uint32_t)magnitude, (uint32_t)(magnitude >> 32)}};
    return out;
}

wide wide_power_of_two(int n)
{
    wide out = {.negative = false};
    out.limb[n / 32] = UINT32_C(1) << n % 32;
    return out;
}

wide wide_negated(wide a)
{
    a.negative = !a.negative && !is_zero(&a);
    return a;
}

wide wide_plus(wide a, wide b)
{
    const bool same_sign = a.negative == b.negative, swap = !same_sign && magnitude_order(&a, &b) < 0;
    const wide *more = swap ? &b : &a, *less = swap ? &a : &b;
    wide out = {.negative = more->negative};
    int64_t carry = 0;
    for (int i = 0; i < WIDE_LIMBS; i++) {
        carry += (int64_t)more->limb[i] + (same_sign ? (int64_t)less->limb[i] : -(int64_t)less->limb[i]);
        out.limb[i] = (uint32_t)((uint64_t)carry & 0xffffffff);
        carry = carry < 0 ? -1 : carry >> 32;
    }
    if (is_zero(&out))
        out.negative = false;
    return out;
}

wide wide_minus(wide a, wide b)
{
    return wide_plus(a, wide_negated(b));
}

static int limbs_of(const wide *a)
{
    int n = WIDE_LIMBS;
    while (n > 0 && !a->limb[n - 1])
        n--;
    return n;
}

wide wide_times(wide a, wide b)
{
    wide out = {.negative = false};
    const int n = limbs_of(&a), m = limbs_of(&b);
    for (int i = 0; i < n; i++) {
        uint64_t carry = 0;
        for (int j = 0; i + j < WIDE_LIMBS && (j < m || carry); j++) {
            carry += (uint64_t)a.limb[i] * b.limb[j] + out.limb[i + j];
            out.limb[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
    }
    out.negative = a.negative != b.negative && !is_zero(&out);
    return out;
}

int wide_order(wide a, wide b)
{
    if (a.negative != b.negative)
        return a.negative ? -1 : 1;
    return a.negative ? -magnitude_order(&a, &b) : magnitude_order(&a, &b);
}

static int bits_of(const wide *a)
{
    const int n = limbs_of(a);
    int bits = 32 * (n - 1);
    for (uint32_t top = n ? a->limb[n - 1] : 0; top; top >>= 1)
        bits++;
    return n ? bits : 0;
}

static wide shifted(const wide *a, int by)
{
    wide out = {.negative = a->negative};
    for (int i = WIDE_LIMBS - 1; i >= by / 32; i--) {
        out.limb[i] = a->limb[i - by / 32] << by % 32;
        if (by % 32 && i > by / 32)
            out.limb[i] |= a->limb[i - by / 32 - 1] >> (32 - by % 32);
    }
    return out;
}

/* Returns the greatest q with q * b <= a. The loop determines the bits of q (two's complement) from the highest
   to the lowest. `product` is always q * b. */
wide wide_floor(wide a, wide b)
{
    const int bits = bits_of(&a) - bits_of(&b) + 1 > 0 ? bits_of(&a) - bits_of(&b) + 1 : 0;
    wide q = wide_of(0), product = q;
    if (a.negative) { /* |a / b| < 2^bits, so `bits` steps of the long division are sufficient */
        q = wide_negated(wide_power_of_two(bits));
        product = wide_negated(shifted(&b, bits));
    }
    for (int i = bits - 1; i >= 0; i--) {
        const wide more = wide_plus(product, shifted(&b, i));
        if (wide_order(more, a) <= 0) {
            q = wide_plus(q, wide_power_of_two(i));
            product = more;
        }
    }
    return q;
}

/* Returns a / b rounded to the nearest integer, and to the even integer if two integers are equally near. */
wide wide_nearest(wide a, wide b)
{
    const wide below = wide_floor(a, b), above = wide_plus(below, wide_of(1));
    const int nearer = wide_order(wide_minus(a, wide_times(below, b)), wide_minus(wide_times(above, b), a));
    if (nearer == 0)
        return below.limb[0] % 2 == 0 ? below : above;
    return nearer < 0 ? below : above;
}

int64_t wide_to_int64(wide a)
{
    uint64_t words[2];
    wide_to_words(a, words);
    return bits_of(&a) < 64 ? (int64_t)words[0] : 0;
}

void wide_to_words(wide a, uint64_t words[2])
{
    words[0] = a.limb[0] | (uint64_t)a.limb[1] << 32;
    words[1] = a.limb[2] | (uint64_t)a.limb[3] << 32;
    if (a.negative) {
        words[0] = 0 - words[0];
        words[1] = ~words[1] + (words[0] == 0);
    }
}
