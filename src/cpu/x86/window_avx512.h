/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the windows of sixteen bricks at once (shape.h, "Windows"), for the two AVX-512 variants of `match`. */
#ifndef OST_CPU_X86_WINDOW_AVX512_H
#define OST_CPU_X86_WINDOW_AVX512_H

#include <immintrin.h>

#include "core/conditions.h"
#include "cpu/remove/shape.h"

enum { OST_WINDOW_FRACTION = (1 << OST_MAP_FRACTION) - 1 };

/*
 * Returns for each coordinate u the index of the voxel that contains u, 0 <= index < 2^15. The first voxel of the first
 * window, which is `margin` voxels before the tool, has the index 0.
 */
static inline __m512i ost_window_voxel(__m512i u, int32_t margin)
{
    return _mm512_add_epi32(_mm512_srai_epi32(u, OST_MAP_FRACTION), _mm512_set1_epi32(margin));
}

/*
 * Returns floor(voxel / step) for 0 <= voxel < 2^15 and a step of 1, 2, 3 or 6. For a step of at most 3, this is equal
 * to (voxel * ceil(2^16 / step)) >> 16. The factors of the multiplication are 2 * voxel and ceil(2^16 / step) / 2,
 * because both fit in 16 bits. For a step of 6, floor(voxel / 2) is divided by 3.
 */
static inline __m512i ost_window_of(__m512i voxel, int32_t step)
{
    const int32_t inverse = step % 3 == 0 ? 21846 : step == 2 ? 32768 : 65536;
    const __m512i twice = step == 6 ? _mm512_and_si512(voxel, _mm512_set1_epi32(~1)) : _mm512_add_epi32(voxel, voxel);
    return _mm512_mulhi_epu16(twice, _mm512_set1_epi32(inverse / 2));
}

/* Returns the number of the window at the position `window`. Each axis has fewer than 2^15 windows. */
static inline __m512i ost_window_number(const ost_windows *w, const __m512i window[3])
{
    const __m512i row = _mm512_add_epi32(window[1], _mm512_madd_epi16(window[2], _mm512_set1_epi32(w->dims[1])));
    return _mm512_add_epi32(window[0], _mm512_mullo_epi32(row, _mm512_set1_epi32(w->dims[0])));
}

/* Replaces window numbers with the numbers of the windows' lines, and prefetches these lines. */
static inline void ost_find_lines(const ost_windows *windows, size_t count, uint32_t *number)
{
    const uint8_t(*const line)[64] = windows->line;
    const uint32_t *const index = windows->index;
    for (size_t i = 0; i < count; i++) {
        number[i] = index[number[i]];
        _mm_prefetch((const char *)line[number[i]], _MM_HINT_T0);
    }
}

#endif
