/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/row_loops.h"

#include <immintrin.h>

OST_ROWS_DEFINE(avx512)

/* Processes sixteen voxels, half of a row. Packs those that have an exposed face. */
static inline uint32_t *half_row(const ost_faces *faces, uint32_t row, int shift, uint32_t *points)
{
    const __mmask16 any = (__mmask16)(faces->any[row] >> shift);
    if (!any)
        return points;
    __m512i v = _mm512_add_epi32(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
                                 _mm512_set1_epi32((int)(row << 5) + shift));
    for (int f = 0; f < 6; f++)
        v = _mm512_mask_or_epi32(v, (__mmask16)(faces->face[f][row] >> shift), v,
                                 _mm512_set1_epi32(1 << (OST_FACES_SHIFT + f)));
    /* compressing in a register is faster than a compressing store */
    _mm512_storeu_si512(points, _mm512_maskz_compress_epi32(any, v));
    return points + _mm_popcnt_u32(any);
}

void ost_rows_points_avx512(const ost_faces *faces, uint32_t *points)
{
    for (uint32_t first = 0; first < OST_BLOCK_ROWS; first += 16) {
        const __m512i any = _mm512_loadu_si512(faces->any + first);
        for (uint32_t left = _mm512_test_epi32_mask(any, any); left; left &= left - 1) {
            const uint32_t row = first + (uint32_t)__builtin_ctz(left);
            points = half_row(faces, row, 0, points);
            points = half_row(faces, row, 16, points);
        }
    }
}
