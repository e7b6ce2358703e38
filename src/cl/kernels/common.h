/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small exact functions that all kernels use.  This file is OpenCL C 1.2.  It is also
 * C11 if tests/cl/opencl_c.h is included first.  The functions do not rely on undefined or
 * implementation-defined behaviour: no signed overflow, no shift of a negative value,
 * and no shift by the width of the type.
 */

/*
 * The kernel sets of this program: 1 is the set for many small work items, 2 is the set for few large work items, and 3
 * is both sets (shared.h).
 */
#ifndef OST_FOR
#define OST_FOR 3
#endif

/* The number of adjacent voxels of a row that a work item computes; see shared.h. */
#ifndef OST_RUN
#define OST_RUN 3
#endif

/*
 * With the option -DOST_ORDER=s, s > 0, work items are permuted: item i of n does the work of item (i + s) mod n if s
 * is even, and of item (n - 1 - i + s) mod n if s is odd.  The permutation must not change any result.
 */
#ifdef OST_ORDER
static inline size_t ost_item(uint dimension)
{
    const size_t n = get_global_size(dimension), i = get_global_id(dimension);
    return ((OST_ORDER % 2 ? n - 1 - i : i) + OST_ORDER % n) % n;
}
#define get_global_id(dimension) ost_item(dimension)
#endif

/* Returns n / d rounded down, for d > 0 (AR-INT-1). */
static inline long ost_floor_div(long n, long d)
{
    const long q = n / d;
    return n % d < 0 ? q - 1 : q;
}

static inline long ost_ceil_div(long n, long d)
{
    const long q = n / d;
    return n % d > 0 ? q + 1 : q;
}

/*
 * Returns RHE(n / d) (AR-INT-2) for d > 0. Let q = floor(n / d) and r = n - q d, so that 0 <= r < d. The result
 * is q + 1 if r > d - r, or if r = d - r and q is odd; otherwise, it is q.
 */
static inline long ost_rhe_div(long n, long d)
{
    const long q = ost_floor_div(n, d);
    const long r = n - q * d;
    return (r > d - r || (r == d - r && q % 2 != 0)) ? q + 1 : q;
}

/*
 * ost_mean15 returns RHE(sum / 2^15) for |sum| <= 2^30, and ost_mean45 returns
 * RHE(sum / 2^45) for |sum| <= 2^60.  The result is a weighted mean of densities
 * (AR-CUB-2).  Let `unit` be 2^15 or 2^45, respectively:
 *
 *   up     = sum + 2^15 unit                            up >= 0
 *   odd    = floor(up / unit) mod 2                     1 if floor(sum / unit) is odd, as 2^15 is even
 *   result = floor((up + unit / 2 - 1 + odd) / unit) - 2^15
 */
static inline short ost_mean15(int sum)
{
    const uint up = (uint)(sum + (1 << 30));
    return (short)((int)((up + 0x3fffu + (up >> 15 & 1u)) >> 15) - 32768);
}

static inline short ost_mean45(long sum)
{
    const ulong up = (ulong)(sum + (1l << 60));
    return (short)((int)((up + ((1ul << 44) - 1ul) + (up >> 45 & 1ul)) >> 45) - 32768);
}

static inline int ost_least(int a, int b)
{
    return a < b ? a : b;
}

static inline int ost_greatest(int a, int b)
{
    return a > b ? a : b;
}

static inline uint ost_clamped(uint v, uint lo, uint hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/* For OpenCL C, these macros build a vector with x in every element. For C, tests/cl/opencl_c.h defines them. */
#ifndef OST_ALL16
#define OST_ALL16(x) ((uint16)(x))
#define OST_ALL8(x) ((int8)(x))
#endif

/* Returns 16 bits, of which the bits lo <= b < hi are set. lo and hi may have any value. */
static inline uint ost_bits16(int lo, int hi)
{
    const int from = ost_greatest(lo, 0), to = ost_least(hi, 16);
    return from < to ? (0xffffu >> (16 - (to - from))) << from : 0u;
}

/* Returns the number of trailing zero bits of a word that is not 0. */
static inline int ost_lowest_bit(uint word)
{
    return 31 - (int)clz(word & (0u - word));
}

/* A bijective function of 64 bits that maps 0 to 0: the finaliser of splitmix64 (Steele, Lea and Flood 2014). */
static inline ulong ost_mix(ulong z)
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ul;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebul;
    return z ^ (z >> 31);
}
