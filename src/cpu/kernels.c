/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/kernels.h"

#include "config.h"

static void fill_scalar(ost_cpu_kernels *k)
{
    k->brick_row = ost_brick_row_scalar;
    k->split = ost_split_scalar;
    k->match = ost_match_scalar;
    k->take = ost_take_scalar;
}

#if HAVE_AVX2_BUILD
static void fill_avx2(ost_cpu_kernels *k)
{
    k->split = ost_split_avx2;
    k->match = ost_match_avx2;
    k->take = ost_take_avx2;
}
#endif

#if HAVE_AVX512_BUILD
static void fill_avx512(ost_cpu_kernels *k)
{
    k->split = ost_split_avx512;
    k->match = ost_match_avx512;
    k->take = ost_take_avx512;
}
#endif

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa)
{
    *kernels = (ost_cpu_kernels){.isa = isa};
    fill_scalar(kernels);
#if HAVE_AVX2_BUILD
    if (isa == OST_ISA_AVX2 || isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        fill_avx2(kernels);
#endif
#if HAVE_AVX512_BUILD
    if (isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        fill_avx512(kernels);
#endif
}
