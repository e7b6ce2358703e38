/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The floating-point state that a process starts with, for code whose results must
 * not depend on the caller's state (rounding, traps, flushing of denormals) and that
 * must not change that state:
 *
 *   const ost_floats caller = ost_floats_enter();
 *   ...
 *   ost_floats_leave(caller);
 *
 * Each thread that computes must call both functions, as threads of OpenMP inherit
 * the state of the thread that started them.  Vector code also divides in lanes
 * whose results are not used, where a caller's trap on division by zero would be
 * raised.
 */
#ifndef OST_CORE_FLOATS_H
#define OST_CORE_FLOATS_H

#include <stdint.h>

#if defined __SSE__

typedef unsigned int ost_floats;

static inline ost_floats ost_floats_enter(void)
{
    const ost_floats state = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(0x1f80); /* no traps, rounding to nearest, denormals not flushed */
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

/*
 * Other machines have only scalar loops, which never divide by zero and are exact in any rounding mode
 * (src/cpu/voxelize/mark.c).
 */
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
