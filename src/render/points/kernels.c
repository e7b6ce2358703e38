/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "render/points/splat.h"

ost_splat_kernels ost_splat_kernels_of(ost_isa isa)
{
    ost_splat_kernels k = {ost_facing_scalar, ost_splat_scalar, ost_resolve_scalar, ost_farthest_scalar,
                           ost_merge_scalar};
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        k = (ost_splat_kernels){ost_facing_scalar, ost_splat_avx2, ost_resolve_avx2, ost_farthest_avx2, ost_merge_avx2};
#endif
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        k = (ost_splat_kernels){ost_facing_avx512, ost_splat_avx512, ost_resolve_avx512, ost_farthest_avx512,
                                ost_merge_avx512};
#endif
    (void)isa;
    return k;
}
