/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The part of OpenCL C 1.2 that is needed to compile the kernels of src/cl/kernels as C11. The
 * compiler's warnings, the sanitizers and a debugger then work on the kernels. A kernel becomes a
 * function that is called once for every work item; test_item is the number of the work item.
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
#define __constant static const

static _Thread_local size_t test_item[3];

static inline size_t get_global_id(uint dimension)
{
    return test_item[dimension];
}

/* as_int and as_uint reinterpret the bits of their argument. AR-CC-1 defines the result of a narrowing conversion. */
static inline int as_int(uint x) { return (int)x; }
static inline uint as_uint(int x) { return (uint)x; }
static inline long as_long(ulong x) { return (long)x; }
static inline short as_short(ushort x) { return (short)x; }
static inline signed char as_char(uchar x) { return (signed char)x; }

/* Vectors use the vector extension of GCC and clang, in which operators work as in OpenCL C and comparisons give 0
   or -1. The functions are always inlined. No sanitizer detects an overflow in an element of a vector. Instead,
   comments in the kernels prove the bounds, and the tests use meshes and poses at the ends of the ranges. */
#pragma GCC diagnostic ignored "-Wpsabi"
typedef uchar uchar8 __attribute__((vector_size(8)));
typedef short short16 __attribute__((vector_size(32)));
typedef ushort ushort16 __attribute__((vector_size(32)));
typedef int int8 __attribute__((vector_size(32)));
typedef uint uint8 __attribute__((vector_size(32)));
typedef int int16 __attribute__((vector_size(64)));
typedef uint uint16 __attribute__((vector_size(64)));
typedef signed char char8 __attribute__((vector_size(8)));
typedef long long8 __attribute__((vector_size(64)));
typedef ulong ulong8 __attribute__((vector_size(64)));

#define OST_ALL16(x) ((uint16){0} + (uint)(x))
#define OST_ALL8(x) ((int8){0} + (int)(x))
#define select(a, b, c) (((a) & ~(__typeof__(a))(c)) | ((b) & (__typeof__(a))(c)))

#define TEST_VECTOR(type, element, n) \
    static inline type test_load_##type(const element *p) { type v; __builtin_memcpy(&v, p, sizeof v); return v; } \
    static inline void test_store_##type(type v, element *p) { __builtin_memcpy(p, &v, sizeof v); }
TEST_VECTOR(uchar8, uchar, 8)
TEST_VECTOR(int8, int, 8)
TEST_VECTOR(uint8, uint, 8)
TEST_VECTOR(short16, short, 16)
TEST_VECTOR(ushort16, ushort, 16)
TEST_VECTOR(int16, int, 16)
TEST_VECTOR(uint16, uint, 16)
#define vload8(i, p)                                                                                                   \
    _Generic((p), uchar *: test_load_uchar8, const uchar *: test_load_uchar8, int *: test_load_int8, \
             const int *: test_load_int8, \
             const uint *: test_load_uint8, uint *: test_load_uint8)((p) + 8 * (i))
#define vload16(i, p) \
    _Generic((p), short *: test_load_short16, const short *: test_load_short16, const ushort *: test_load_ushort16, \
             const uint *: test_load_uint16)((p) + 16 * (i))
#define vstore8(v, i, p) test_store_int8(v, (p) + 8 * (i))
#define vstore16(v, i, p) \
    _Generic((p), short *: test_store_short16, int *: test_store_int16, uint *: test_store_uint16)(v, (p) + 16 * (i))

#define as_int8(v) ((int8)(v))
#define as_int16(v) ((int16)(v))
#define as_long8(v) ((long8)(v))
#define as_ulong8(v) ((ulong8)(v))
#define as_short16(v) ((short16)(v))
static inline ulong test_as_ulong_i64(long x) { return (ulong)x; }
static inline ulong test_as_ulong_u8(uchar8 v) { return (ulong)v; }
static inline ulong test_as_ulong_i8(char8 v) { return (ulong)v; }
#define as_ulong(x) _Generic((x), long: test_as_ulong_i64, uchar8: test_as_ulong_u8, char8: test_as_ulong_i8)(x)
#define convert_int16(v) __builtin_convertvector(v, int16)
#define convert_int8(v) __builtin_convertvector(v, int8)
#define convert_char8(v) __builtin_convertvector(v, char8)
#define convert_long8(v) __builtin_convertvector(v, long8)

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

/* Relaxed atomic operations on uint and int, as in OpenCL 1.2. Each returns the old value. */
#define atomic_add(p, x) __atomic_fetch_add(p, x, __ATOMIC_RELAXED)
#define atomic_sub(p, x) __atomic_fetch_sub(p, x, __ATOMIC_RELAXED)
#define atomic_inc(p) __atomic_fetch_add(p, 1, __ATOMIC_RELAXED)
#define atomic_dec(p) __atomic_fetch_sub(p, 1, __ATOMIC_RELAXED)
#define atomic_or(p, x) __atomic_fetch_or(p, x, __ATOMIC_RELAXED)
#define atomic_and(p, x) __atomic_fetch_and(p, x, __ATOMIC_RELAXED)
#define atomic_xor(p, x) __atomic_fetch_xor(p, x, __ATOMIC_RELAXED)
#define atomic_xchg(p, x) __atomic_exchange_n(p, x, __ATOMIC_RELAXED)
/* Work items are executed one after the other, so minimum and maximum need not be atomic here. */
static inline uint test_max_u32(volatile uint *p, uint x) { uint old = *p; *p = x > old ? x : old; return old; }
static inline uint test_min_u32(volatile uint *p, uint x) { uint old = *p; *p = x < old ? x : old; return old; }
static inline int test_max_i32(volatile int *p, int x) { int old = *p; *p = x > old ? x : old; return old; }
static inline int test_min_i32(volatile int *p, int x) { int old = *p; *p = x < old ? x : old; return old; }
#define atomic_max(p, x) _Generic((p), volatile uint *: test_max_u32, volatile int *: test_max_i32)(p, x)
#define atomic_min(p, x) _Generic((p), volatile uint *: test_min_u32, volatile int *: test_min_i32)(p, x)

#endif
