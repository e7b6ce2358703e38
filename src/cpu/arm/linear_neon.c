/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Linear interpolation for NEON. Each step interpolates eight voxels between two slices, or computes four sums. The
 * ranges are the same as in x86/linear_avx512.c: the sums of the `blend` kernel are at most 2^30, those of the `weigh`
 * kernel are at most 2^60, and a quotient fits in 16 bits.
 */
#include "core/conditions.h"
#include "core/neon.h"
#include "cpu/kernels.h"

enum { LANES = 8 };

/* Returns RHE(sum / 2^15) for each of four sums. */
static inline int16x4_t rounded15(int32x4_t sum)
{
    const int32x4_t odd = vandq_s32(vshrq_n_s32(sum, OST_WEIGHT_BITS), vdupq_n_s32(1));
    return vshrn_n_s32(vaddq_s32(vaddq_s32(sum, vdupq_n_s32((1 << (OST_WEIGHT_BITS - 1)) - 1)), odd), OST_WEIGHT_BITS);
}

static inline int16x4_t blended(int16x4_t a, int16x4_t b, int16_t lower, int16_t upper)
{
    return rounded15(vmlal_n_s16(vmull_n_s16(a, lower), b, upper));
}

static inline void blend(const int16_t *a, const int16_t *b, int16_t lower, int16_t upper, int16_t *to)
{
    const int16x8_t va = vld1q_s16(a), vb = vld1q_s16(b);
    vst1q_s16(to, vcombine_s16(blended(vget_low_s16(va), vget_low_s16(vb), lower, upper),
                               blended(vget_high_s16(va), vget_high_s16(vb), lower, upper)));
}

void ost_blend_rows_neon(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                         int16_t *to)
{
    /* both weights are in 1..2^15 - 1, so they fit in int16 */
    const int16_t lower = (int16_t)(OST_WEIGHT_ONE - weight), upper = (int16_t)weight;
    if (width < LANES) {
        ost_blend_rows_scalar(a, b, row, count, width, weight, to);
        return;
    }
    for (int r = 0; r < count; r++) {
        const int16_t *const ra = a + row[r], *const rb = b + row[r];
        int16_t *const result = to + (size_t)OST_ROW_STRIDE * (size_t)r;
        for (int x = 0; x + LANES <= width; x += LANES)
            blend(ra + x, rb + x, lower, upper, result + x);
        if (width % LANES) /* interpolates the last eight voxels of the row; some of them are computed a second time */
            blend(ra + width - LANES, rb + width - LANES, lower, upper, result + width - LANES);
    }
}

/* Returns the low 32 bits of RHE(sum / 2^45) for each of two sums. */
static inline int32x2_t rounded45(int64x2_t sum)
{
    const int64x2_t odd = vandq_s64(vshrq_n_s64(sum, 3 * OST_WEIGHT_BITS), vdupq_n_s64(1));
    const int64x2_t half = vdupq_n_s64((INT64_C(1) << (3 * OST_WEIGHT_BITS - 1)) - 1);
    return vmovn_s64(vshrq_n_s64(vaddq_s64(vaddq_s64(sum, half), odd), 3 * OST_WEIGHT_BITS));
}

void ost_weigh_rows_neon(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to)
{
    for (int i = 0; i < width; i += 4) {
        int64x2_t low = vdupq_n_s64(0), high = low;
        for (int r = 0; r < count; r++) {
            const int32x4_t v = vld1q_s32(rows[r] + i);
            low = vmlal_n_s32(low, vget_low_s32(v), weight[r]);
            high = vmlal_high_n_s32(high, v, weight[r]);
        }
        vst1_s16(to + i, vmovn_s32(vcombine_s32(rounded45(low), rounded45(high))));
    }
}
