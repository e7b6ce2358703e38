/* SPDX-License-Identifier: Apache-2.0 */
/* The list of the instruction sets that the compiler was allowed to use for the baselines. This file
   contains only data, so a processor without these instruction sets can read the list. */
#include "bench/baseline.h"

#if defined __SSE3__
#define HAS_SSE3 1
#else
#define HAS_SSE3 0
#endif
#if defined __SSSE3__
#define HAS_SSSE3 1
#else
#define HAS_SSSE3 0
#endif
#if defined __SSE4_1__
#define HAS_SSE4_1 1
#else
#define HAS_SSE4_1 0
#endif
#if defined __SSE4_2__
#define HAS_SSE4_2 1
#else
#define HAS_SSE4_2 0
#endif
#if defined __POPCNT__
#define HAS_POPCNT 1
#else
#define HAS_POPCNT 0
#endif
#if defined __AVX__
#define HAS_AVX 1
#else
#define HAS_AVX 0
#endif
#if defined __FMA__
#define HAS_FMA 1
#else
#define HAS_FMA 0
#endif
#if defined __BMI__
#define HAS_BMI 1
#else
#define HAS_BMI 0
#endif
#if defined __BMI2__
#define HAS_BMI2 1
#else
#define HAS_BMI2 0
#endif
#if defined __AVX2__
#define HAS_AVX2 1
#else
#define HAS_AVX2 0
#endif
#if defined __AVX512F__
#define HAS_AVX512F 1
#else
#define HAS_AVX512F 0
#endif
#if defined __AVX512CD__
#define HAS_AVX512CD 1
#else
#define HAS_AVX512CD 0
#endif
#if defined __AVX512BW__
#define HAS_AVX512BW 1
#else
#define HAS_AVX512BW 0
#endif
#if defined __AVX512DQ__
#define HAS_AVX512DQ 1
#else
#define HAS_AVX512DQ 0
#endif
#if defined __AVX512VL__
#define HAS_AVX512VL 1
#else
#define HAS_AVX512VL 0
#endif
#if defined __AVX512IFMA__
#define HAS_AVX512IFMA 1
#else
#define HAS_AVX512IFMA 0
#endif
#if defined __AVX512VBMI__
#define HAS_AVX512VBMI 1
#else
#define HAS_AVX512VBMI 0
#endif
#if defined __AVX512VBMI2__
#define HAS_AVX512VBMI2 1
#else
#define HAS_AVX512VBMI2 0
#endif
#if defined __AVX512VNNI__
#define HAS_AVX512VNNI 1
#else
#define HAS_AVX512VNNI 0
#endif
#if defined __AVX512BITALG__
#define HAS_AVX512BITALG 1
#else
#define HAS_AVX512BITALG 0
#endif
#if defined __AVX512VPOPCNTDQ__
#define HAS_AVX512VPOPCNTDQ 1
#else
#define HAS_AVX512VPOPCNTDQ 0
#endif
#if defined __GFNI__
#define HAS_GFNI 1
#else
#define HAS_GFNI 0
#endif

enum {
#define PLACE(id, name) PLACE_##id,
    BENCH_NATIVE_LIST(PLACE)
#undef PLACE
};

const uint32_t bench_native_needs =
#define BIT(id, name) (uint32_t)HAS_##id << PLACE_##id |
    BENCH_NATIVE_LIST(BIT)
#undef BIT
    0;
