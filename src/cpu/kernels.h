/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops of the CPU backend.  Every slot is filled with its scalar
 * function first and then overwritten as far as the instruction set allows,
 * so no slot is ever NULL and every variant has the scalar one to be held to
 * (tests/simd).  A kernel checks nothing: its contract stands beside its slot.
 *
 *   ost_cpu_kernels_fill(k, isa):   scalar -> avx2 -> avx512 -> avx512vbmi
 *                                   scalar -> neon
 */
#ifndef OST_CPU_KERNELS_H
#define OST_CPU_KERNELS_H

#include "core/isa.h"

typedef struct ost_cpu_kernels {
    ost_isa isa; /* the level they were filled for */
} ost_cpu_kernels;

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa);

#endif
