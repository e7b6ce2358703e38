/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The CPU backend: the reference's results, to the bit, as fast as this
 * machine gives them.
 *
 *   cpu.c       the table, options "isa=" and "threads="
 *   kernels.c   the inner loops, chosen once at open
 *   bone.c      chunks of bricks: slices in and out, leaves
 *   remove.c    removal and collision, with shape.c: a tool's distances and windows
 *
 * Whatever has no fast form yet is the reference's own function: the objects
 * embed the reference's.  Threads take whole chunks, slices or columns and
 * share nothing they write; results are put in order afterwards.
 */
#ifndef OST_CPU_CPU_H
#define OST_CPU_CPU_H

#include "core/isa.h"
#include "cpu/kernels.h"
#include "cpu/ref/ref.h"
#include "cpu/remove_event.h"

typedef struct cpu_backend {
    ref_backend ref; /* first: the reference's functions run on it */
    ost_isa isa;
    int threads; /* >= 1 */
    ost_cpu_kernels kernels;
    ost_event_scratch event;
} cpu_backend;

#endif
