/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts rows of voxels into bricks, four bricks at a time.  Four rows contain a
 * quarter of each of the four bricks, as words of four voxels.  The words are transposed,
 * so that each quarter is one register.
 */
#include "core/conditions.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

#include <immintrin.h>

enum { GROUP = 4, LANES = 16 };

static inline void put(int16_t *to, __m256i v, bool stream)
{
    if (stream)
        _mm256_stream_si256((void *)to, v);
    else
        _mm256_store_si256((void *)to, v);
}

static inline void quarters(const int16_t *const rows[4], size_t x, __m256i quarter[GROUP])
{
    __m256i r0 = _mm256_loadu_si256((const void *)(rows[0] + x)), r1 = _mm256_loadu_si256((const void *)(rows[1] + x));
    __m256i r2 = _mm256_loadu_si256((const void *)(rows[2] + x)), r3 = _mm256_loadu_si256((const void *)(rows[3] + x));
    __m256i even01 = _mm256_unpacklo_epi64(r0, r1), odd01 = _mm256_unpackhi_epi64(r0, r1);
    __m256i even23 = _mm256_unpacklo_epi64(r2, r3), odd23 = _mm256_unpackhi_epi64(r2, r3);
    quarter[0] = _mm256_permute2x128_si256(even01, even23, 0x20);
    quarter[1] = _mm256_permute2x128_si256(odd01, odd23, 0x20);
    quarter[2] = _mm256_permute2x128_si256(even01, even23, 0x31);
    quarter[3] = _mm256_permute2x128_si256(odd01, odd23, 0x31);
}

/*
 * Converts the results of 32 comparisons of 16-bit lanes to bits. The packing instruction works within
 * halves of a register, so the quarters of its result must be reordered.
 */
static inline uint32_t bits_of(__m256i on0, __m256i on1)
{
    return (uint32_t)_mm256_movemask_epi8(_mm256_permute4x64_epi64(_mm256_packs_epi16(on0, on1), 0xd8));
}

static inline __attribute__((always_inline)) ost_brick_sums brick_row(const int16_t *const rows[16], size_t bricks,
                                                                      int16_t threshold, bool stream, int16_t *density,
                                                                      uint64_t *occupancy)
{
    const __m256i below = _mm256_set1_epi16((int16_t)(threshold - 1)); /* threshold >= 1 */
    __m256i highest = _mm256_setzero_si256();
    int32_t active = 0;
    for (size_t x = 0; x < bricks; x += GROUP) {
        __m256i part[4][GROUP];
        for (int z = 0; z < 4; z++)
            quarters(rows + 4 * z, 4 * x, part[z]);
        for (size_t i = 0; i < GROUP; i++) {
            size_t at = (size_t)ost_brick_spread((int32_t)(x + i));
            __m256i on[4];
            for (int z = 0; z < 4; z++) {
                on[z] = _mm256_cmpgt_epi16(part[z][i], below);
                __m256i v = _mm256_and_si256(part[z][i], on[z]);
                put(density + at * OST_BRICK_VOXELS + (size_t)z * LANES, v, stream);
                highest = _mm256_max_epi16(highest, v);
            }
            occupancy[at] = bits_of(on[0], on[1]) | (uint64_t)bits_of(on[2], on[3]) << 32;
            active += (int32_t)_mm_popcnt_u64(occupancy[at]);
        }
    }
    __m128i quarter = _mm_max_epi16(_mm256_castsi256_si128(highest), _mm256_extracti128_si256(highest, 1));
    /*
     * Computes the maximum of the lanes v, none of which is negative. SSE4.1 has an instruction for the minimum of
     * unsigned 16-bit lanes but none for the maximum, so the minimum of 2^15 - 1 - v is computed.
     */
    __m128i least_complement = _mm_minpos_epu16(_mm_xor_si128(quarter, _mm_set1_epi16(INT16_MAX)));
    return (ost_brick_sums){active, _mm_extract_epi16(least_complement, 0) ^ INT16_MAX};
}

ost_brick_sums ost_brick_row_avx2(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                  int16_t *density, uint64_t *occupancy)
{
    return stream ? brick_row(rows, bricks, threshold, true, density, occupancy)
                  : brick_row(rows, bricks, threshold, false, density, occupancy);
}

bool ost_any_active_avx2(const int16_t *base, const size_t *row, int count, int width, int16_t threshold)
{
    const __m256i below = _mm256_set1_epi16((int16_t)(threshold - 1));
    const int full = width / LANES * LANES;
    __m256i most = _mm256_setzero_si256();
    for (int r = 0; r < count; r++) {
        for (int x = 0; x < full; x += LANES)
            most = _mm256_max_epi16(most, _mm256_loadu_si256((const void *)(base + row[r] + x)));
        for (int x = full; x < width; x++)
            if (base[row[r] + (size_t)x] >= threshold)
                return true;
    }
    __m256i on = _mm256_cmpgt_epi16(most, below);
    return !_mm256_testz_si256(on, on);
}

void ost_drain_avx2(void)
{
    _mm_sfence();
}
