/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/row_loops.h"

#include <immintrin.h>

OST_ROWS_DEFINE(avx2)

/* Returns the positions of the set bits of an 8-bit number in ascending order, as octal digits (three bits each). */
static inline uint32_t order_of(uint32_t bits)
{
    static const uint16_t four[16] = {0, 00, 01, 010, 02, 020, 021, 0210, 03, 030, 031, 0310, 032, 0320, 0321, 03210};
    return four[bits & 15] | (four[bits >> 4] | 04444u) << (3 * _mm_popcnt_u32(bits & 15));
}

/* Processes eight voxels, a quarter of a row. Packs those that have an exposed face. */
static inline uint32_t *quarter(const ost_faces *faces, uint32_t row, int shift, uint32_t *points)
{
    const uint32_t any = faces->any[row] >> shift & 255;
    if (!any)
        return points;
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
                  bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    __m256i v = _mm256_add_epi32(lane, _mm256_set1_epi32((int)(row << 5) + shift));
    for (int f = 0; f < 6; f++) {
        const __m256i has = _mm256_cmpeq_epi32(
            _mm256_and_si256(_mm256_set1_epi32((int)(faces->face[f][row] >> shift)), bit), bit);
        v = _mm256_or_si256(v, _mm256_and_si256(has, _mm256_set1_epi32(1 << (OST_FACES_SHIFT + f))));
    }
    const __m256i order = _mm256_srlv_epi32(_mm256_set1_epi32((int)order_of(any)),
                                            _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));
    _mm256_storeu_si256((void *)points, _mm256_permutevar8x32_epi32(v, order));
    return points + _mm_popcnt_u32(any);
}

void ost_rows_points_avx2(const ost_faces *faces, uint32_t *points)
{
    for (uint32_t row = 0; row < OST_BLOCK_ROWS; row++)
        for (int shift = 0; shift < OST_BLOCK && faces->any[row] >> shift; shift += 8)
            points = quarter(faces, row, shift, points);
}
