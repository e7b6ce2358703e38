/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels of the voxelizer for x86. cpu/kernels.h has their contracts. */
#ifndef OST_CPU_X86_VOXELIZE_X86_H
#define OST_CPU_X86_VOXELIZE_X86_H

#include "cpu/kernels.h"

ost_vox_mark_fn ost_vox_mark_avx2, ost_vox_mark_avx512;
ost_vox_keys_fn ost_vox_keys_avx2, ost_vox_keys_avx512;
ost_vox_fill_fn ost_vox_fill_avx2, ost_vox_fill_avx512;
ost_vox_expand_fn ost_vox_expand_avx2, ost_vox_expand_avx512;

#endif
