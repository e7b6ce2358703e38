/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/slopes.h"

enum { LINE = OST_FIELD_LINE };

void ost_field_bits_scalar(const uint64_t *rows, int count, uint16_t (*out)[LINE])
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i++)
            out[row][i] = (uint16_t)(OST_FIELD_ALL * (rows[row] >> (i + OST_LINE_SHIFT) & 1));
}

void ost_field_densities_scalar(uint64_t row, uint64_t near, const int16_t density[LINE], uint16_t out[LINE])
{
    for (int i = 0; i < LINE; i++) {
        const int v = density[i], some = OST_FIELD_LEAST + (v < 0 ? 0 : v / 16), bit = i + OST_LINE_SHIFT;
        const int bone = near >> bit & 1 || v >= OST_FIELD_DENSE ? OST_FIELD_ALL : some;
        out[i] = (uint16_t)(row >> bit & 1 ? bone : 0);
    }
}

static inline unsigned nine(const uint16_t *a, ptrdiff_t step)
{
    const unsigned outer = (unsigned)a[0] + a[8 * step] + 2u * ((unsigned)a[step] + a[7 * step]);
    const unsigned inner = 3u * ((unsigned)a[2 * step] + a[6 * step]) + 4u * ((unsigned)a[3 * step] + a[5 * step]) + 5u * a[4 * step];
    return outer + inner;
}

void ost_field_down_scalar(const uint16_t (*in)[LINE], uint16_t (*out)[LINE], int count)
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i++)
            out[row][i] = (uint16_t)nine(&in[row][i], LINE);
}

void ost_field_slice_scalar(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out)
{
    for (; rows; rows &= rows - 1) {
        const int row = __builtin_ctzll(rows);
        uint16_t z[LINE];
        for (int i = 0; i < LINE; i++) {
            uint16_t a[9];
            for (int k = 0; k < 9; k++)
                a[k] = (*y[k])[row][i];
            z[i] = (uint16_t)((nine(a, 1) + 8) >> 4);
        }
        for (int i = 0; i < OST_FIELD_ROWS; i++)
            (*out)[row][i] = (uint16_t)nine(&z[i + OST_LINE_SKIP], 1);
    }
}

void ost_field_looks_scalar(const uint32_t *points, int count, const ost_field_slice *const slice[3], uint32_t *looks)
{
    for (int i = 0; i < count; i++) {
        ost_slopes s;
        float out[3];
        ost_slope_at(points[i], slice, &s, 0);
        for (int a = 0; a < 3; a++)
            out[a] = (float)ost_slope_with_faces(s.out[a][0], s.faces[0], a);
        looks[i] = ost_octahedral_of(out) | ost_openness(s.field[0]) << OST_OPEN_SHIFT;
    }
}

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa)
{
    ost_smooth_kernels k = {ost_field_bits_scalar, ost_field_densities_scalar, ost_field_down_scalar, ost_field_slice_scalar, ost_field_looks_scalar};
#if HAVE_AVX2_BUILD
    if (isa == OST_ISA_AVX2 || isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        k = (ost_smooth_kernels){ost_field_bits_avx2, ost_field_densities_avx2, ost_field_down_avx2, ost_field_slice_avx2, ost_field_looks_avx2};
#endif
#if HAVE_AVX512_BUILD
    if (isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        k = (ost_smooth_kernels){ost_field_bits_avx512, ost_field_densities_avx512, ost_field_down_avx512, ost_field_slice_avx512, ost_field_looks_avx512};
#endif
    (void)isa;
    return k;
}
