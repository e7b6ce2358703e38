/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The expected results of kernels/fingerprint.cl, word by word. The host's methods differ from the kernel's: the host
 * uses 128-bit products, 32-bit digits, or single bits. The words have the same indices as in the kernel.
 */
#ifndef OST_CL_FINGERPRINT_EXPECT_H
#define OST_CL_FINGERPRINT_EXPECT_H

#include <string.h>

#include "cl/kernels/shared.h"
#include "core/integer.h"

__extension__ typedef unsigned __int128 ost_cl_u128;

static inline unsigned ost_cl_bits_of(uint64_t x)
{
    unsigned bits = 0;
    for (; x; x &= x - 1)
        bits++;
    return bits;
}

static inline unsigned ost_cl_zeros_before(uint64_t x, int width)
{
    unsigned zeros = 0;
    for (int bit = width - 1; bit >= 0 && !(x >> bit & 1); bit--)
        zeros++;
    return zeros;
}

static inline void ost_cl_fingerprint_expect(uint64_t a, uint64_t b, uint64_t to[OST_CL_FINGERPRINT])
{
    const uint32_t a32 = (uint32_t)a, b32 = (uint32_t)b;
    const int by = (int)(b & 63), by32 = (int)(b & 31);
    const ost_cl_u128 product = (ost_cl_u128)a * b;
    const ost_i128 sa = (int64_t)a, sb = (int64_t)b, sa32 = (int32_t)a32, sb32 = (int32_t)b32; /* AR-CC-1 */
    const uint64_t d = b | 1;
    const ost_i128 sd = (ost_i128)(b >> 1 | 1), sd32 = (ost_i128)(b32 >> 1 | 1);
    const uint64_t low24 = a & 0xffffff;

    to[0] = (uint64_t)product;
    to[1] = (uint64_t)(product >> 64);
    to[2] = (uint64_t)(sa * sb >> 64);
    to[3] = (uint64_t)((ost_cl_u128)a32 * b32);
    to[4] = (uint64_t)(sa32 * sb32);
    to[5] = low24 * low24 / (UINT64_C(1) << 32);
    to[6] = (uint64_t)(sa32 * 100);
    to[7] = (uint64_t)((ost_cl_u128)a32 * b32 >> 32);
    to[8] = (uint32_t)(sa32 * sb32 >> 32);
    to[9] = (uint32_t)(a32 * (uint64_t)b32);
    to[10] = (uint64_t)(product >> 20);
    to[11] = (uint64_t)((ost_cl_u128)a + b);
    to[12] = (uint64_t)(((ost_cl_u128)a + b) >> 64);
    to[13] = (uint64_t)((ost_cl_u128)a - b);
    to[14] = (uint64_t)(((ost_cl_u128)a - b) >> 127);
    to[15] = ((uint64_t)a32 + b32) % (UINT64_C(1) << 32) * 2 + ((uint64_t)a32 + b32) / (UINT64_C(1) << 32);
    to[16] = (uint64_t)((ost_cl_u128)a << by);
    to[17] = (uint64_t)((ost_cl_u128)a >> by);
    to[18] = (uint64_t)(((ost_cl_u128)a << by) | ((ost_cl_u128)a << by) >> 64);
    to[19] = ((uint64_t)a32 << by32) % (UINT64_C(1) << 32) << 32 | (uint64_t)a32 >> by32;
    to[20] = (uint64_t)((ost_cl_u128)a / d);
    to[21] = a - to[20] * d;
    to[22] = (uint64_t)(sa / sd);
    to[23] = (uint64_t)(sa - sa / sd * sd);
    to[24] = (uint64_t)(a32 / (uint32_t)d) << 32 | (a32 - a32 / (uint32_t)d * (uint32_t)d);
    to[25] = (uint64_t)(uint32_t)(sa32 / sd32) << 32 | (uint32_t)(sa32 - sa32 / sd32 * sd32);
    to[26] = (uint64_t)ost_rhe_div128((ost_i128)(a >> 2) - (ost_i128)(b >> 2), sd);
    to[27] = (uint64_t)ost_cl_zeros_before(a, 64) << 24 | (uint64_t)ost_cl_zeros_before(a32, 32) << 16 |
             (uint64_t)ost_cl_bits_of(a) << 8 | ost_cl_bits_of(b32);
    to[28] = (sa < sb ? 1u : 0u) | (sa32 < sb32 ? 2u : 0u) | (a32 < b32 ? 4u : 0u) |
             (((uint64_t)(sa < sb ? sa : sb) ^ (a > b ? a : b)) << 3);
    to[29] = (uint64_t)((ost_i128)(int16_t)(uint16_t)a + (int8_t)(uint8_t)b);
    to[30] = (a & 0xffff) << 32 | (b & 0xff);
    uint64_t z = a ^ b;
    z = (uint64_t)((ost_cl_u128)(z ^ z / (UINT64_C(1) << 30)) * UINT64_C(0xbf58476d1ce4e5b9));
    z = (uint64_t)((ost_cl_u128)(z ^ z / (UINT64_C(1) << 27)) * UINT64_C(0x94d049bb133111eb));
    to[31] = z ^ z / (UINT64_C(1) << 31);
}

/* Sets counters[] to the values that are expected after all work items have ended. The array `in` has `count` words. */
static inline void ost_cl_fingerprint_expect_atomics(const uint64_t *in, uint32_t count,
                                                     uint32_t counters[OST_CL_FINGERPRINT_COUNTERS])
{
    memset(counters, 0, OST_CL_FINGERPRINT_COUNTERS * sizeof *counters);
    counters[5] = counters[7] = UINT32_MAX;
    int32_t least = 0, most = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t x = (uint32_t)in[i];
        counters[0] += x;
        counters[1] -= x;
        counters[2]++;
        counters[3]--;
        counters[4] = x > counters[4] ? x : counters[4];
        counters[5] = x < counters[5] ? x : counters[5];
        counters[6] |= x;
        counters[7] &= x;
        counters[8] ^= x;
        least = (int32_t)x < least ? (int32_t)x : least;
        most = (int32_t)x > most ? (int32_t)x : most;
        counters[11 + x % 5]++;
    }
    counters[9] = (uint32_t)least;
    counters[10] = (uint32_t)most;
}
#endif
