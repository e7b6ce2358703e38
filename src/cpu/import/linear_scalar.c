/* SPDX-License-Identifier: Apache-2.0 */
#include "core/integer.h"
#include "cpu/kernels.h"

/*
 * Returns RHE(sum / 2^bits). Because the shift rounds down, 2^(bits - 1) - 1 is added to the sum first, and 1 more if
 * the floor of the quotient is odd.
 */
static inline int64_t rhe_shift(int64_t sum, int bits)
{
    return (sum + (INT64_C(1) << (bits - 1)) - 1 + (sum >> bits & 1)) >> bits;
}

/*
 * Computes weighted means of two rows. |sum| <= 2^15 * 2^15 for each sum, because the weights are positive and sum to
 * 2^15.
 */
void ost_blend_rows_scalar(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                           int16_t *to)
{
    for (int r = 0; r < count; r++)
        for (int i = 0; i < width; i++)
            to[OST_ROW_STRIDE * r + i] = (int16_t)rhe_shift(
                a[row[r] + (size_t)i] * (OST_WEIGHT_ONE - weight) + b[row[r] + (size_t)i] * weight, OST_WEIGHT_BITS);
}

/* Interpolates a row along x. |to[i]| <= 2^30, because the weights have the same sign and sum to -2^15. */
void ost_stretch_row_scalar(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to)
{
    for (int i = 0; i < width; i++)
        to[i] = from[at[i]] * minus[2 * i] + from[at[i] + 1] * minus[2 * i + 1];
}

/*
 * Computes a weighted mean of up to four rows. |sum| <= 2^30 * 2^30 for each sum, because the weights have the same
 * sign and sum to 2^30 or -2^30.
 */
void ost_weigh_rows_scalar(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to)
{
    for (int i = 0; i < width; i++) {
        int64_t sum = 0;
        for (int r = 0; r < count; r++)
            sum += (int64_t)rows[r][i] * weight[r];
        to[i] = (int16_t)rhe_shift(sum, 3 * OST_WEIGHT_BITS);
    }
}
