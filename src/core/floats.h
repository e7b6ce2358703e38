/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sets the floating-point state to the initial state of a process, and restores the caller's state
 * afterwards.  Used by code whose results must not depend on the caller's state (rounding mode,
 * traps, flushing of denormals) and that must not change this state:
 *
 *   const ost_floats caller = ost_floats_enter();
 *   ...
 *   ost_floats_leave(caller);
 *
 * Each computing thread must call both functions, because OpenMP threads inherit the state of the
 * thread that started them.  Traps must be off, because vector code also divides in lanes whose
 * results are not used, and in these lanes the divisor may be zero.
 */
#ifndef OST_CORE_FLOATS_H
#define OST_CORE_FLOATS_H

#include <stdint.h>

#if defined __SSE__

typedef unsigned int ost_floats;

static inline ost_floats ost_floats_enter(void)
{
    const ost_floats state = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(0x1f80); /* MXCSR: all exceptions masked, rounding to nearest, denormals kept */
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
 * On other machines only scalar loops are used. They never divide by zero and are exact in any rounding
 * mode (src/cpu/voxelize/mark.c).
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
