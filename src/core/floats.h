/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The float state that every thread starts with, for code whose floats must
 * not depend on what a caller has set (rounding, traps, flushing of denormals),
 * and that must not leave anything of its own to the caller:
 *
 *   const ost_floats caller = ost_floats_enter();
 *   ...
 *   ost_floats_leave(caller);
 *
 * In each thread that computes: threads of OpenMP have the state of whoever
 * began them.  A vector divides in lanes that nobody looks at, too, so a caller
 * that traps on division by zero would meet it here.
 */
#ifndef OST_CORE_FLOATS_H
#define OST_CORE_FLOATS_H

#include <stdint.h>

#if defined __SSE__

typedef unsigned int ost_floats;

static inline ost_floats ost_floats_enter(void)
{
    const ost_floats state = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(0x1f80); /* no trap, to nearest, denormals kept */
    return state;
}

static inline void ost_floats_leave(ost_floats state)
{
    __builtin_ia32_ldmxcsr(state);
}

#elif defined __aarch64__

typedef uint64_t ost_floats;

static inline ost_floats ost_floats_enter(void)
{
    ost_floats state;
    __asm__ volatile("mrs %0, fpcr" : "=r"(state));
    __asm__ volatile("msr fpcr, %0" : : "r"((uint64_t)0));
    return state;
}

static inline void ost_floats_leave(ost_floats state)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(state));
}

#else

/* Scalar loops alone: they divide by nothing that is zero, and are right in any rounding (src/cpu/voxelize/mark.c). */
typedef int ost_floats;

static inline ost_floats ost_floats_enter(void)
{
    return 0;
}

static inline void ost_floats_leave(ost_floats state)
{
    (void)state;
}

#endif

#endif
