/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small exact functions of the kernels.  OpenCL C 1.2, and C11 after
 * tests/cl/opencl_c.h.  Nothing here relies on undefined or implementation-defined
 * behaviour: no signed overflow, no shift of a negative value or by the width.
 */

/* The kernel sets: for many small items (1), for few strong ones (2), or both; see shared.h. */
#ifndef OST_FOR
#define OST_FOR 3
#endif

/* Voxels of a row that an item copies; see shared.h. */
#ifndef OST_RUN
#define OST_RUN 3
#endif

/*
 * With -DOST_ORDER=s, s > 0, work items are permuted: item i of n does the work of
 * item (i or n - 1 - i) + s modulo n.  No result may depend on it.
 */
#ifdef OST_ORDER
static inline size_t ost_item(uint dimension)
{
    const size_t n = get_global_size(dimension), i = get_global_id(dimension);
    return ((OST_ORDER % 2 ? n - 1 - i : i) + OST_ORDER % n) % n;
}
#define get_global_id(dimension) ost_item(dimension)
#endif

/* AR-INT-1; d > 0. */
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

/* AR-INT-2; d > 0. With r = n - floor d, 0 <= r < d: rounds up if r > d - r, and if they are equal and the floor is
   odd. */
static inline long ost_rhe_div(long n, long d)
{
    const long q = ost_floor_div(n, d);
    const long r = n - q * d;
    return (r > d - r || (r == d - r && q % 2 != 0)) ? q + 1 : q;
}

/*
 * These return RHE(sum / 2^15), |sum| <= 2^30, and RHE(sum / 2^45), |sum| <= 2^60:
 * a weighted mean of densities (AR-CUB-2).  2^15 units are added, which makes the
 * sum >= 0 and preserves the parity of its quotient; then half a unit less 1, and 1
 * more if the floor is odd, before the floor is taken.
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

/* Vectors with x in every element. tests/cl/opencl_c.h defines them for C. */
#ifndef OST_ALL16
#define OST_ALL16(x) ((uint16)(x))
#define OST_ALL8(x) ((int8)(x))
#endif

/* Returns the bits lo <= b < hi of 16 bits, for any lo and hi. */
static inline uint ost_bits16(int lo, int hi)
{
    const int from = ost_greatest(lo, 0), to = ost_least(hi, 16);
    return from < to ? (0xffffu >> (16 - (to - from))) << from : 0u;
}

/* Returns the number of trailing zeros; word != 0. */
static inline int ost_lowest_bit(uint word)
{
    return 31 - (int)clz(word & (0u - word));
}

/* Maps 64 bits bijectively: the finaliser of splitmix64 (Steele, Lea and Flood 2014). 0 is mapped to 0. */
static inline ulong ost_mix(ulong z)
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ul;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebul;
    return z ^ (z >> 31);
}
