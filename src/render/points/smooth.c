/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/smooth.h"

void ost_nine_scalar(const uint16_t *restrict in, uint16_t *restrict out, int count, int step, bool sixteenth)
{
    for (int i = 0; i < count; i++) {
        const uint16_t *a = in + i;
        const unsigned outer = (unsigned)a[0] + a[8 * step] + 2u * ((unsigned)a[step] + a[7 * step]);
        const unsigned inner = 3u * ((unsigned)a[2 * step] + a[6 * step]) + 4u * ((unsigned)a[3 * step] + a[5 * step]) + 5u * a[4 * step];
        const unsigned sum = outer + inner;
        out[i] = (uint16_t)(sixteenth ? (sum + 8) >> 4 : sum);
    }
}

void ost_field_bits_scalar(uint64_t row, uint16_t out[OST_FIELD_LINE])
{
    for (int i = 0; i < OST_FIELD_LINE; i++)
        out[i] = (uint16_t)(OST_FIELD_ALL * (row >> i & 1));
}

void ost_field_densities_scalar(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE])
{
    for (int i = 0; i < OST_FIELD_LINE; i++) {
        const int v = density[i], some = OST_FIELD_LEAST + (v < 0 ? 0 : v / 16);
        const int bone = near >> i & 1 || v >= OST_FIELD_DENSE ? OST_FIELD_ALL : some;
        out[i] = (uint16_t)(row >> i & 1 ? bone : 0);
    }
}

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa)
{
    ost_smooth_kernels k = {ost_nine_scalar, ost_field_bits_scalar, ost_field_densities_scalar};
#if HAVE_AVX2_BUILD
    if (isa == OST_ISA_AVX2 || isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        k = (ost_smooth_kernels){ost_nine_avx2, ost_field_bits_avx2, ost_field_densities_avx2};
#endif
#if HAVE_AVX512_BUILD
    if (isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        k = (ost_smooth_kernels){ost_nine_avx512, ost_field_bits_avx512, ost_field_densities_avx512};
#endif
    (void)isa;
    return k;
}
