/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Enough of OpenCL C 1.2 for the kernels of src/cl/kernels to be C11: then the
 * compiler's warnings and sanitizers see them, and a debugger does.  A kernel is a
 * function that is called once for every item; test_item says which.
 */
#ifndef OST_TESTS_CL_OPENCL_C_H
#define OST_TESTS_CL_OPENCL_C_H

#include <stddef.h>
#include <stdint.h>

typedef unsigned char uchar;
typedef unsigned short ushort;
typedef unsigned int uint;
typedef unsigned long ulong;
_Static_assert(sizeof(long) == 8 && sizeof(int) == 4 && sizeof(short) == 2, "the widths of OpenCL C");

#define __kernel static
#define __global

static _Thread_local size_t test_item[3];

static inline size_t get_global_id(uint dimension)
{
    return test_item[dimension];
}

/* Conversions of bits. AR-CC-1 says what narrowing does. */
static inline int as_int(uint x) { return (int)x; }
static inline uint as_uint(int x) { return (uint)x; }
static inline long as_long(ulong x) { return (long)x; }
static inline ulong as_ulong(long x) { return (ulong)x; }
static inline short as_short(ushort x) { return (short)x; }
static inline signed char as_char(uchar x) { return (signed char)x; }

static inline uint test_clz(ulong x, int width)
{
    uint zeros = 0;
    for (int bit = width - 1; bit >= 0 && !(x >> bit & 1u); bit--)
        zeros++;
    return zeros;
}
#define clz(x) test_clz(x, (int)sizeof(x) * 8)
#define popcount(x) ((uint)__builtin_popcountl(x))

__extension__ typedef __int128 test_i128;
__extension__ typedef unsigned __int128 test_u128;
static inline ulong test_mul_hi_u64(ulong a, ulong b) { return (ulong)((test_u128)a * b >> 64); }
static inline long test_mul_hi_i64(long a, long b) { return (long)((test_i128)a * b >> 64); }
static inline uint test_mul_hi_u32(uint a, uint b) { return (uint)((ulong)a * b >> 32); }
static inline int test_mul_hi_i32(int a, int b) { return (int)((long)a * b >> 32); }
#define mul_hi(a, b) \
    _Generic((a), ulong: test_mul_hi_u64, long: test_mul_hi_i64, uint: test_mul_hi_u32, int: test_mul_hi_i32)(a, b)

static inline ulong rotate(ulong x, ulong by)
{
    by &= 63;
    return by ? x << by | x >> (64 - by) : x;
}
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))

/* Relaxed, as OpenCL 1.2's are; on uint and int. Each gives the old value. */
#define atomic_add(p, x) __atomic_fetch_add(p, x, __ATOMIC_RELAXED)
#define atomic_sub(p, x) __atomic_fetch_sub(p, x, __ATOMIC_RELAXED)
#define atomic_inc(p) __atomic_fetch_add(p, 1, __ATOMIC_RELAXED)
#define atomic_dec(p) __atomic_fetch_sub(p, 1, __ATOMIC_RELAXED)
#define atomic_or(p, x) __atomic_fetch_or(p, x, __ATOMIC_RELAXED)
#define atomic_and(p, x) __atomic_fetch_and(p, x, __ATOMIC_RELAXED)
#define atomic_xor(p, x) __atomic_fetch_xor(p, x, __ATOMIC_RELAXED)
#define atomic_xchg(p, x) __atomic_exchange_n(p, x, __ATOMIC_RELAXED)
/* Items are called one after the other here. */
static inline uint test_max_u32(volatile uint *p, uint x) { uint old = *p; *p = x > old ? x : old; return old; }
static inline uint test_min_u32(volatile uint *p, uint x) { uint old = *p; *p = x < old ? x : old; return old; }
static inline int test_max_i32(volatile int *p, int x) { int old = *p; *p = x > old ? x : old; return old; }
static inline int test_min_i32(volatile int *p, int x) { int old = *p; *p = x < old ? x : old; return old; }
#define atomic_max(p, x) _Generic((p), volatile uint *: test_max_u32, volatile int *: test_max_i32)(p, x)
#define atomic_min(p, x) _Generic((p), volatile uint *: test_min_u32, volatile int *: test_min_i32)(p, x)

#endif
