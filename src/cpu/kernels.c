/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "cpu/kernels.h"

#include "cpu/voxelize/voxelize.h"
#if HAVE_AVX2_BUILD || HAVE_AVX512_BUILD
#include "cpu/x86/voxelize_x86.h"
#endif

static void fill_scalar(ost_cpu_kernels *k)
{
    k->gather_row = ost_gather_row_scalar;
    k->blend_rows = ost_blend_rows_scalar;
    k->stretch_row = ost_stretch_row_scalar;
    k->weigh_rows = ost_weigh_rows_scalar;
    k->brick_row = ost_brick_row_scalar;
    k->any_active = ost_any_active_scalar;
    k->drain = ost_drain_scalar;
    k->sample = ost_sample_scalar;
    k->blocks = ost_blocks_scalar;
    k->split = ost_split_scalar;
    k->match_tables = ost_match_ties;
    k->match = ost_match_scalar;
    k->take = ost_take_scalar;
    k->vox_mark = ost_vox_mark_scalar;
    k->vox_keys = ost_vox_keys_scalar;
    k->vox_fill = ost_vox_fill_scalar;
    k->vox_expand = ost_vox_expand_scalar;
}

#if HAVE_AVX2_BUILD
static void fill_avx2(ost_cpu_kernels *k)
{
    k->blend_rows = ost_blend_rows_avx2;
    k->stretch_row = ost_stretch_row_avx2;
    k->weigh_rows = ost_weigh_rows_avx2;
    k->brick_row = ost_brick_row_avx2;
    k->any_active = ost_any_active_avx2;
    k->drain = ost_drain_avx2;
    k->split = ost_split_avx2;
    k->match = ost_match_avx2;
    k->take = ost_take_avx2;
    k->vox_mark = ost_vox_mark_avx2;
    k->vox_keys = ost_vox_keys_avx2;
    k->vox_fill = ost_vox_fill_avx2;
    k->vox_expand = ost_vox_expand_avx2;
}
#endif

#if HAVE_AVX512_BUILD
static void fill_avx512(ost_cpu_kernels *k)
{
    k->gather_row = ost_gather_row_avx512;
    k->blend_rows = ost_blend_rows_avx512;
    k->stretch_row = ost_stretch_row_avx512;
    k->weigh_rows = ost_weigh_rows_avx512;
    k->brick_row = ost_brick_row_avx512;
    k->any_active = ost_any_active_avx512;
    k->sample = ost_sample_avx512;
    k->blocks = ost_blocks_avx512;
    k->split = ost_split_avx512;
    k->match = ost_match_avx512;
    k->take = ost_take_avx512;
    k->vox_mark = ost_vox_mark_avx512;
    k->vox_keys = ost_vox_keys_avx512;
    k->vox_fill = ost_vox_fill_avx512;
    k->vox_expand = ost_vox_expand_avx512;
}
#endif

#if HAVE_AVX512VBMI_BUILD
static void fill_avx512vbmi(ost_cpu_kernels *k)
{
    k->match_tables = ost_match_carries_avx512vbmi;
    k->match = ost_match_avx512vbmi;
}
#endif

#if HAVE_NEON_BUILD
/*
 * The slots gather_row, stretch_row and vox_fill have no NEON variant, because NEON would not make them faster:
 * gather_row and stretch_row need one load for each lane, and vox_fill needs the borrow of the previous word.
 */
static void fill_neon(ost_cpu_kernels *k)
{
    k->blend_rows = ost_blend_rows_neon;
    k->weigh_rows = ost_weigh_rows_neon;
    k->brick_row = ost_brick_row_neon;
    k->any_active = ost_any_active_neon;
    k->split = ost_split_neon;
    k->match = ost_match_neon;
    k->take = ost_take_neon;
    k->vox_mark = ost_vox_mark_neon;
    k->vox_keys = ost_vox_keys_neon;
    k->vox_expand = ost_vox_expand_neon;
}
#endif

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa)
{
    *kernels = (ost_cpu_kernels){.isa = isa};
    fill_scalar(kernels);
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        fill_avx2(kernels);
#endif
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        fill_avx512(kernels);
#endif
#if HAVE_AVX512VBMI_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512VBMI))
        fill_avx512vbmi(kernels);
#endif
#if HAVE_NEON_BUILD
    if (isa == OST_ISA_NEON)
        fill_neon(kernels);
#endif
}
