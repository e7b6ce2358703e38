/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replaces the compiler's header in the portable kernels. The NEON intrinsics are portable C from SIMDe. See
 * immintrin.h.
 */
#ifndef OST_TESTS_SIMD_PORTABLE_ARM_NEON_H
#define OST_TESTS_SIMD_PORTABLE_ARM_NEON_H
#pragma GCC system_header

#define SIMDE_NO_NATIVE
#define SIMDE_NO_CHECK_IMMEDIATE_CONSTANT
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/arm/neon.h>

/*
 * SIMDe defines vcltq_f64 as a macro with parameters. The preprocessor would treat the commas in a compound literal as
 * separators of the macro's arguments, so the macro is replaced by the function.
 */
#undef vcltq_f64
#define vcltq_f64 simde_vcltq_f64

#undef vdivq_f64 /* Later versions of SIMDe define this function. */
static inline float64x2_t vdivq_f64(float64x2_t a, float64x2_t b)
{
    return a / b;
}

#endif
