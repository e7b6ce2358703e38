/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/row_loops.h"

OST_ROWS_DEFINE(scalar)

void ost_rows_points_scalar(const ost_faces *faces, uint32_t *points)
{
    for (uint32_t row = 0; row < OST_BLOCK_ROWS; row++)
        for (uint32_t left = faces->any[row]; left; left &= left - 1) {
            const int x = __builtin_ctz(left);
            uint32_t mask = 0;
            for (int f = 0; f < 6; f++)
                mask |= (faces->face[f][row] >> x & 1) << f;
            *points++ = (uint32_t)x | row << 5 | mask << OST_FACES_SHIFT;
        }
}

ost_row_kernels ost_row_kernels_of(ost_isa isa)
{
    ost_row_kernels k = {ost_rows_join_scalar, ost_rows_spread_scalar, ost_rows_faces_scalar, ost_rows_behind_scalar,
                         ost_rows_points_scalar};
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        k = (ost_row_kernels){ost_rows_join_avx2, ost_rows_spread_avx2, ost_rows_faces_avx2, ost_rows_behind_avx2,
                              ost_rows_points_avx2};
#endif
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        k = (ost_row_kernels){ost_rows_join_avx512, ost_rows_spread_avx512, ost_rows_faces_avx512,
                              ost_rows_behind_avx512, ost_rows_points_avx512};
#endif
    (void)isa;
    return k;
}
