/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replaces the compiler's header in the portable kernels. The x86 intrinsics are portable C, most of them from SIMDe.
 *
 * SIMDe 0.7.4 (Debian 12) lacks some of the intrinsics that the kernels use. This file defines them lane by lane,
 * according to Intel's manual, and test_intrinsics compares each of them with the results of a processor. A masked load
 * or store accesses only the lanes of its mask, so guard pages find the same errors as with the processor's
 * instructions.
 *
 * Some of SIMDe's short names are wrong, because they have the parameters of another intrinsic. This file defines them
 * again.
 */
#ifndef OST_TESTS_SIMD_PORTABLE_IMMINTRIN_H
#define OST_TESTS_SIMD_PORTABLE_IMMINTRIN_H
#pragma GCC system_header /* SIMDe does not compile without warnings */

#include <stdint.h>
#include <string.h>

#define SIMDE_NO_NATIVE
/*
 * Without this macro, clang checks that immediate arguments are constant before it inlines the functions, and reports
 * an error.
 */
#define SIMDE_NO_CHECK_IMMEDIATE_CONSTANT
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/avx512.h>

#define OST_PORTABLE static inline __attribute__((always_inline))

/* SIMDe 0.8 (Debian 13) defines __mmask64 and simde__mmask64 as different types. Here, both names are the same type. */
typedef simde__mmask8 __mmask8;
typedef simde__mmask16 __mmask16;
#undef __mmask32
#undef __mmask64
#define __mmask32 simde__mmask32
#define __mmask64 simde__mmask64

#undef _MM_FROUND_NO_EXC
#define _MM_FROUND_NO_EXC SIMDE_MM_FROUND_NO_EXC

#undef _mm512_madd_epi16
#define _mm512_madd_epi16 simde_mm512_madd_epi16
#undef _mm512_mask_cmpge_epi16_mask
#define _mm512_mask_cmpge_epi16_mask simde_mm512_mask_cmpge_epi16_mask
#undef _mm512_mask_cmpge_epi32_mask
#define _mm512_mask_cmpge_epi32_mask simde_mm512_mask_cmpge_epi32_mask
#undef _mm512_mask_cmple_epi32_mask
#define _mm512_mask_cmple_epi32_mask simde_mm512_mask_cmple_epi32_mask
#undef _mm_mask_cmpge_epi8_mask
#define _mm_mask_cmpge_epi8_mask simde_mm_mask_cmpge_epi8_mask

/* Later versions of SIMDe define some of these. */
#undef _bzhi_u32
#undef _cvtmask64_u64
#undef _cvtu64_mask64
#undef _mm256_cmpgt_epi32_mask
#undef _mm256_mask_cmplt_epu32_mask
#undef _mm512_alignr_epi32
#undef _mm512_cmplt_epi32_mask
#undef _mm512_cmplt_epu32_mask
#undef _mm512_cmplt_epu64_mask
#undef _mm512_cmpneq_epi32_mask
#undef _mm512_cvtepi32_epi16
#undef _mm512_cvtepi32_epi64
#undef _mm512_cvtepi32_epi8
#undef _mm512_cvtepi32_pd
#undef _mm512_cvtepi32_ps
#undef _mm512_cvtepi64_epi16
#undef _mm512_cvtepu8_epi32
#undef _mm512_cvtpd_epi32
#undef _mm512_cvtsi512_si32
#undef _mm512_cvttps_epi32
#undef _mm512_i32gather_epi32
#undef _mm512_lzcnt_epi64
#undef _mm512_mask_cmp_ps_mask
#undef _mm512_mask_cmplt_epi32_mask
#undef _mm512_mask_cmplt_epu32_mask
#undef _mm512_mask_cmplt_epu64_mask
#undef _mm512_mask_cvtepi32_storeu_epi16
#undef _mm512_mask_i32gather_epi32
#undef _mm512_mask_i64gather_epi32
#undef _mm512_mask_i64gather_epi64
#undef _mm512_mask_loadu_epi8
#undef _mm512_mask_reduce_max_epi32
#undef _mm512_mask_reduce_min_epi32
#undef _mm512_mask_store_epi32
#undef _mm512_mask_store_ps
#undef _mm512_mask_storeu_epi16
#undef _mm512_mask_storeu_epi64
#undef _mm512_mask_storeu_epi8
#undef _mm512_mask_sub_epi16
#undef _mm512_maskz_loadu_epi16
#undef _mm512_maskz_loadu_epi32
#undef _mm512_maskz_loadu_epi64
#undef _mm512_mulhi_epu16
#undef _mm512_reduce_add_epi32
#undef _mm512_reduce_add_epi64
#undef _mm512_reduce_max_epu64
#undef _mm512_shuffle_i64x2
#undef _mm512_sra_epi32
#undef _mm512_srai_epi32
#undef _mm512_srai_epi64
#undef _mm512_srav_epi32
#undef _mm512_stream_si512
#undef _mm_cmpeq_epi8_mask
#undef _mm_cmple_epi8_mask
#undef _mm_mask_storeu_epi16
#undef _mm_mask_storeu_epi8
#undef _mm_maskz_loadu_epi32
#undef _mm_popcnt_u32
#undef _mm_popcnt_u64
#undef _mm_test_epi8_mask
#undef _pdep_u64
#undef _pext_u32
#undef _pext_u64
#undef _store_mask32
#undef _tzcnt_u32
#undef _tzcnt_u64

/* ----------------------------------------------------------- bits of a word */

OST_PORTABLE int _mm_popcnt_u32(uint32_t a)
{
    return __builtin_popcount(a);
}

OST_PORTABLE long long _mm_popcnt_u64(uint64_t a)
{
    return __builtin_popcountll(a);
}

OST_PORTABLE uint32_t _tzcnt_u32(uint32_t a)
{
    return a ? (uint32_t)__builtin_ctz(a) : 32;
}

OST_PORTABLE uint64_t _tzcnt_u64(uint64_t a)
{
    return a ? (uint64_t)__builtin_ctzll(a) : 64;
}

OST_PORTABLE uint32_t _bzhi_u32(uint32_t a, uint32_t index)
{
    return (index & 255) < 32 ? a & ((UINT32_C(1) << (index & 255)) - 1) : a;
}

OST_PORTABLE uint64_t _pext_u64(uint64_t a, uint64_t mask)
{
    uint64_t r = 0;
    for (int i = 0; mask; mask &= mask - 1, i++)
        r |= (a >> __builtin_ctzll(mask) & 1) << i;
    return r;
}

OST_PORTABLE uint32_t _pext_u32(uint32_t a, uint32_t mask)
{
    return (uint32_t)_pext_u64(a, mask);
}

OST_PORTABLE uint64_t _pdep_u64(uint64_t a, uint64_t mask)
{
    uint64_t r = 0;
    for (; mask; mask &= mask - 1, a >>= 1)
        r |= (a & 1) << __builtin_ctzll(mask);
    return r;
}

/* -------------------------------------------------------------------- lanes */

/* Copies the lanes of register `a` to a new array `v` of `count` elements. */
#define OST_LANES(type, count, v, a) \
    type v[count];                   \
    memcpy(v, &(a), sizeof v)

/* Defines NAME(a). Lane i of the result is the value of `expression`, in which x is lane i of a. */
#define OST_UNARY(name, to_reg, to, from_reg, from, count, expression) \
    OST_PORTABLE to_reg name(from_reg a)                               \
    {                                                                  \
        OST_LANES(from, count, in, a);                                 \
        to out[count];                                                 \
        to_reg r;                                                      \
        for (int i = 0; i < count; i++) {                              \
            const from x = in[i];                                      \
            out[i] = (to)(expression);                                 \
        }                                                              \
        memcpy(&r, out, sizeof r);                                     \
        return r;                                                      \
    }

/* Defines a comparison. Bit i of the result is the value of `expression`; x is lane i of a, and y is lane i of b. */
#define OST_COMPARE(name, mask, reg, type, count, expression) \
    OST_PORTABLE mask name(reg a, reg b)                      \
    {                                                         \
        OST_LANES(type, count, in, a);                        \
        OST_LANES(type, count, other, b);                     \
        mask r = 0;                                           \
        for (int i = 0; i < count; i++) {                     \
            const type x = in[i], y = other[i];               \
            r |= (mask)((mask)(expression) << i);             \
        }                                                     \
        return r;                                             \
    }

/* Defines a load of the lanes that a mask selects; the other lanes are 0. */
#define OST_MASKZ_LOAD(name, mask, reg, type, count)                    \
    OST_PORTABLE reg name(mask k, const void *from)                     \
    {                                                                   \
        type out[count] = {0};                                          \
        reg r;                                                          \
        for (int i = 0; i < count; i++)                                 \
            if (k >> i & 1)                                             \
                memcpy(&out[i], (const type *)from + i, sizeof out[i]); \
        memcpy(&r, out, sizeof r);                                      \
        return r;                                                       \
    }

/* Defines a store of the lanes that a mask selects. */
#define OST_MASK_STORE(name, mask, reg, type, count)          \
    OST_PORTABLE void name(void *to, mask k, reg a)           \
    {                                                         \
        OST_LANES(type, count, in, a);                        \
        for (int i = 0; i < count; i++)                       \
            if (k >> i & 1)                                   \
                memcpy((type *)to + i, &in[i], sizeof in[i]); \
    }

/* Defines a comparison of the lanes that a mask selects; the other bits of the result are 0. */
#define OST_MASK_COMPARE(name, mask, reg, all)   \
    OST_PORTABLE mask name(mask k, reg a, reg b) \
    {                                            \
        return (mask)(k & all(a, b));            \
    }

/* Defines a gather of the lanes that a mask selects. A selected lane i is loaded from `base` + at[i] * scale.
   The other lanes are copied from `other`. */
#define OST_MASK_GATHER(name, mask, reg, type, index_reg, index_type, count)                                           \
    OST_PORTABLE reg name(reg other, mask k, index_reg index, const void *base, int scale)                             \
    {                                                                                                                  \
        OST_LANES(index_type, count, at, index);                                                                       \
        OST_LANES(type, count, out, other);                                                                            \
        for (int i = 0; i < count; i++)                                                                                \
            if (k >> i & 1)                                                                                            \
                memcpy(&out[i], (const void *)((uintptr_t)base + (uintptr_t)(at[i] * (int64_t)scale)), sizeof out[i]); \
        memcpy(&other, out, sizeof other);                                                                             \
        return other;                                                                                                  \
    }

/* Defines a reduction. r is `start` at first; `expression` then combines r with each lane x in turn. */
#define OST_REDUCE(name, reg, type, count, start, expression) \
    OST_PORTABLE type name(reg a)                             \
    {                                                         \
        OST_LANES(type, count, in, a);                        \
        type r = start;                                       \
        for (int i = 0; i < count; i++) {                     \
            const type x = in[i];                             \
            r = (type)(expression);                           \
        }                                                     \
        return r;                                             \
    }

OST_COMPARE(_mm_cmpeq_epi8_mask, __mmask16, __m128i, int8_t, 16, x == y)
OST_COMPARE(_mm_cmple_epi8_mask, __mmask16, __m128i, int8_t, 16, x <= y)
OST_COMPARE(_mm_test_epi8_mask, __mmask16, __m128i, uint8_t, 16, (x & y) != 0)
OST_COMPARE(_mm256_cmpgt_epi32_mask, __mmask8, __m256i, int32_t, 8, x > y)
OST_COMPARE(ost_portable_256_cmplt_epu32, __mmask8, __m256i, uint32_t, 8, x < y)
OST_COMPARE(_mm512_cmplt_epi32_mask, __mmask16, __m512i, int32_t, 16, x < y)
OST_COMPARE(_mm512_cmplt_epu32_mask, __mmask16, __m512i, uint32_t, 16, x < y)
OST_COMPARE(_mm512_cmplt_epu64_mask, __mmask8, __m512i, uint64_t, 8, x < y)
OST_COMPARE(_mm512_cmpneq_epi32_mask, __mmask16, __m512i, int32_t, 16, x != y)
OST_MASK_COMPARE(_mm256_mask_cmplt_epu32_mask, __mmask8, __m256i, ost_portable_256_cmplt_epu32)
OST_MASK_COMPARE(_mm512_mask_cmplt_epi32_mask, __mmask16, __m512i, _mm512_cmplt_epi32_mask)
OST_MASK_COMPARE(_mm512_mask_cmplt_epu32_mask, __mmask16, __m512i, _mm512_cmplt_epu32_mask)
OST_MASK_COMPARE(_mm512_mask_cmplt_epu64_mask, __mmask8, __m512i, _mm512_cmplt_epu64_mask)

/* SIMDe's functions return 1 even if only half of the bits are 0. */
#undef _mm_testz_si128
#undef _mm256_testz_si256
OST_PORTABLE int _mm_testz_si128(__m128i a, __m128i b)
{
    return _mm_test_epi8_mask(a, b) == 0;
}
OST_PORTABLE int _mm256_testz_si256(__m256i a, __m256i b)
{
    OST_LANES(uint64_t, 4, x, a);
    OST_LANES(uint64_t, 4, y, b);
    return ((x[0] & y[0]) | (x[1] & y[1]) | (x[2] & y[2]) | (x[3] & y[3])) == 0;
}

OST_MASKZ_LOAD(_mm_maskz_loadu_epi32, __mmask8, __m128i, int32_t, 4)
/* SIMDe's functions also read the lanes that the mask excludes. */
#undef _mm_maskload_epi32
#undef _mm256_maskload_epi64
OST_PORTABLE __m128i _mm_maskload_epi32(const void *from, __m128i mask)
{
    return _mm_maskz_loadu_epi32((__mmask8)simde_mm_movemask_ps(simde_mm_castsi128_ps(mask)), from);
}
OST_PORTABLE __m256i _mm256_maskload_epi64(const void *from, __m256i mask)
{
    OST_LANES(int64_t, 4, in, mask);
    int64_t out[4] = {0};
    for (int i = 0; i < 4; i++)
        if (in[i] < 0)
            memcpy(&out[i], (const int64_t *)from + i, sizeof out[i]);
    memcpy(&mask, out, sizeof mask);
    return mask;
}

OST_MASKZ_LOAD(_mm512_maskz_loadu_epi16, __mmask32, __m512i, int16_t, 32)
OST_MASKZ_LOAD(_mm512_maskz_loadu_epi32, __mmask16, __m512i, int32_t, 16)
OST_MASKZ_LOAD(_mm512_maskz_loadu_epi64, __mmask8, __m512i, int64_t, 8)
OST_MASK_STORE(_mm_mask_storeu_epi8, __mmask16, __m128i, int8_t, 16)
OST_MASK_STORE(_mm_mask_storeu_epi16, __mmask8, __m128i, int16_t, 8)
OST_MASK_STORE(_mm512_mask_storeu_epi8, __mmask64, __m512i, int8_t, 64)
OST_MASK_STORE(_mm512_mask_storeu_epi16, __mmask32, __m512i, int16_t, 32)
OST_MASK_STORE(_mm512_mask_storeu_epi64, __mmask8, __m512i, int64_t, 8)
OST_MASK_STORE(_mm512_mask_store_epi32, __mmask16, __m512i, int32_t, 16)
OST_MASK_STORE(_mm512_mask_store_ps, __mmask16, __m512, float, 16)

OST_MASK_GATHER(_mm512_mask_i32gather_epi32, __mmask16, __m512i, int32_t, __m512i, int32_t, 16)
OST_MASK_GATHER(_mm512_mask_i64gather_epi32, __mmask8, __m256i, int32_t, __m512i, int64_t, 8)
OST_MASK_GATHER(_mm512_mask_i64gather_epi64, __mmask8, __m512i, int64_t, __m512i, int64_t, 8)
#define _mm512_i32gather_epi32(index, base, scale) \
    _mm512_mask_i32gather_epi32(simde_mm512_setzero_si512(), 0xffff, index, base, scale)

/* Defines an arithmetic shift to the right. A count greater than `last` has the same effect as `last`. */
#define OST_COUNT(count, last) ((uint64_t)(count) < (last) ? (int)(count) : (last))
#define OST_SRAI(name, type, lanes, last)                  \
    OST_PORTABLE __m512i name(__m512i a, unsigned count)   \
    {                                                      \
        OST_LANES(type, lanes, v, a);                      \
        for (int i = 0; i < (lanes); i++)                  \
            v[i] >>= OST_COUNT(count, last);               \
        memcpy(&a, v, sizeof a);                           \
        return a;                                          \
    }
OST_SRAI(_mm512_srai_epi32, int32_t, 16, 31)
OST_SRAI(_mm512_srai_epi64, int64_t, 8, 63)
OST_PORTABLE __m512i _mm512_sra_epi32(__m512i a, __m128i count)
{
    OST_LANES(uint64_t, 2, counts, count);
    return _mm512_srai_epi32(a, (unsigned)OST_COUNT(counts[0], 31));
}
OST_PORTABLE __m512i _mm512_srav_epi32(__m512i a, __m512i count)
{
    OST_LANES(int32_t, 16, v, a);
    OST_LANES(uint32_t, 16, counts, count);
    for (int i = 0; i < 16; i++)
        v[i] >>= OST_COUNT(counts[i], 31);
    memcpy(&a, v, sizeof a);
    return a;
}

OST_UNARY(_mm512_cvtepu8_epi32, __m512i, int32_t, __m128i, uint8_t, 16, x)
OST_UNARY(_mm512_cvtepi32_epi8, __m128i, int8_t, __m512i, int32_t, 16, x)
OST_UNARY(_mm512_cvtepi32_epi16, __m256i, int16_t, __m512i, int32_t, 16, x)
OST_UNARY(_mm512_cvtepi32_epi64, __m512i, int64_t, __m256i, int32_t, 8, x)
OST_UNARY(_mm512_cvtepi64_epi16, __m128i, int16_t, __m512i, int64_t, 8, x)
OST_UNARY(_mm512_cvtepi32_ps, __m512, float, __m512i, int32_t, 16, x)
OST_UNARY(_mm512_cvtepi32_pd, __m512d, double, __m256i, int32_t, 8, x)
/* A value that does not fit becomes INT32_MIN. For doubles, adding and subtracting 1.5 * 2^52 rounds to the nearest
   integer; a tie is rounded to the even integer. */
OST_UNARY(_mm512_cvttps_epi32, __m512i, int32_t, __m512, float, 16,
          x >= -0x1p31f && x < 0x1p31f ? (int32_t)x : INT32_MIN)
OST_UNARY(_mm512_cvtpd_epi32, __m256i, int32_t, __m512d, double, 8,
          x >= -0x1p31 - 0.5 && x < 0x1p31 - 0.5 ? (int32_t)(x + 0x1.8p52 - 0x1.8p52) : INT32_MIN)
OST_UNARY(_mm512_lzcnt_epi64, __m512i, int64_t, __m512i, uint64_t, 8, x ? __builtin_clzll(x) : 64)

OST_REDUCE(_mm512_reduce_add_epi32, __m512i, uint32_t, 16, 0, r + x)
OST_REDUCE(_mm512_reduce_add_epi64, __m512i, uint64_t, 8, 0, r + x)
OST_REDUCE(_mm512_reduce_max_epu64, __m512i, uint64_t, 8, 0, r > x ? r : x)
OST_REDUCE(ost_portable_reduce_min_epi32, __m512i, int32_t, 16, INT32_MAX, r < x ? r : x)
OST_REDUCE(ost_portable_reduce_max_epi32, __m512i, int32_t, 16, INT32_MIN, r > x ? r : x)
#define _mm512_mask_reduce_min_epi32(k, a) \
    ost_portable_reduce_min_epi32(simde_mm512_mask_mov_epi32(simde_mm512_set1_epi32(INT32_MAX), k, a))
#define _mm512_mask_reduce_max_epi32(k, a) \
    ost_portable_reduce_max_epi32(simde_mm512_mask_mov_epi32(simde_mm512_set1_epi32(INT32_MIN), k, a))

OST_PORTABLE __m512i _mm512_shuffle_i64x2(__m512i a, __m512i b, int control)
{
    OST_LANES(uint64_t, 8, x, a);
    OST_LANES(uint64_t, 8, y, b);
    const uint64_t *const from[4] = {x + 2 * (control & 3), x + 2 * (control >> 2 & 3), y + 2 * (control >> 4 & 3),
                                     y + 2 * (control >> 6 & 3)};
    __m512i r;
    for (int i = 0; i < 4; i++)
        memcpy((char *)&r + 16 * i, from[i], 16);
    return r;
}

OST_PORTABLE __m512i _mm512_alignr_epi32(__m512i high, __m512i low, int count)
{
    uint32_t both[32];
    memcpy(both, &low, sizeof low);
    memcpy(both + 16, &high, sizeof high);
    memcpy(&low, both + (count & 15), sizeof low);
    return low;
}

OST_PORTABLE __m512i _mm512_mulhi_epu16(__m512i a, __m512i b)
{
    OST_LANES(uint16_t, 32, x, a);
    OST_LANES(uint16_t, 32, y, b);
    for (int i = 0; i < 32; i++)
        x[i] = (uint16_t)((uint32_t)x[i] * y[i] >> 16);
    memcpy(&a, x, sizeof a);
    return a;
}

OST_PORTABLE __m512i _mm512_mask_loadu_epi8(__m512i other, __mmask64 k, const void *from)
{
    OST_LANES(uint8_t, 64, out, other);
    for (int i = 0; i < 64; i++)
        if (k >> i & 1)
            out[i] = ((const uint8_t *)from)[i];
    memcpy(&other, out, sizeof other);
    return other;
}

OST_PORTABLE void _mm512_mask_cvtepi32_storeu_epi16(void *to, __mmask16 k, __m512i a)
{
    const __m256i narrow = _mm512_cvtepi32_epi16(a);
    __m512i wide = {0};
    memcpy(&wide, &narrow, sizeof narrow);
    _mm512_mask_storeu_epi16(to, k, wide);
}

/* SIMDe's functions do not round. Here, `mode` must be a rounding mode without a scale. */
#undef _mm512_roundscale_pd
#undef _mm512_roundscale_ps
OST_PORTABLE double ost_portable_round(double x, int mode)
{
    return mode & 2 ? mode & 1 ? __builtin_trunc(x) : __builtin_ceil(x)
                    : mode & 1 ? __builtin_floor(x) : __builtin_rint(x);
}
OST_PORTABLE __m512d _mm512_roundscale_pd(__m512d a, int mode)
{
    OST_LANES(double, 8, v, a);
    for (int i = 0; i < 8; i++)
        v[i] = ost_portable_round(v[i], mode);
    memcpy(&a, v, sizeof a);
    return a;
}
OST_PORTABLE __m512 _mm512_roundscale_ps(__m512 a, int mode)
{
    OST_LANES(float, 16, v, a);
    for (int i = 0; i < 16; i++)
        v[i] = (float)ost_portable_round((double)v[i], mode);
    memcpy(&a, v, sizeof a);
    return a;
}

#define _mm512_mask_sub_epi16(other, k, a, b) simde_mm512_mask_mov_epi16(other, k, simde_mm512_sub_epi16(a, b))
#define _mm512_mask_cmp_ps_mask(k, a, b, predicate) ((__mmask16)((k) & simde_mm512_cmp_ps_mask(a, b, predicate)))
#define _mm512_stream_si512(to, a) simde_mm512_store_si512(to, a)
#define _mm512_cvtsi512_si32(a) simde_mm_cvtsi128_si32(simde_mm512_castsi512_si128(a))
#define _cvtmask64_u64(k) ((uint64_t)(k))
#define _cvtu64_mask64(a) ((__mmask64)(a))
#define _store_mask32(to, k) ((void)(*(to) = (k)))

#endif
