/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Instruction sets that are supported by this machine, and those that may be used.
 *
 *   detected  --  supported by processor and operating system (CPUID, XGETBV; NEON on every AArch64)
 *   allowed   --  detected, and not above the level requested by the "isa=" option of a backend
 *                 or, without this option, by the environment variable OSTEON_ISA
 *
 * A level is named after the instruction sets that it requires; an x86 level includes the lower
 * levels.  The code for a level is executed only if the level is allowed.  Therefore no illegal
 * instruction is executed, however the program was built.
 */
#ifndef OST_CORE_ISA_H
#define OST_CORE_ISA_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

/*
 *   scalar      plain C, compiled for the baseline of the build (SSE2 on x86-64)
 *   avx2        AVX2, BMI1, BMI2, LZCNT, POPCNT; FMA is not used
 *   avx512      avx2 and AVX-512 F, BW, DQ, VL, CD
 *   avx512vbmi  avx512 and AVX-512 VBMI
 *   neon        AArch64 Advanced SIMD
 */
#define OST_ISA_LIST(X) \
    X(SCALAR, "scalar") \
    X(AVX2, "avx2")     \
    X(AVX512, "avx512") \
    X(AVX512VBMI, "avx512vbmi") \
    X(NEON, "neon")

typedef enum ost_isa {
#define OST_ISA_ENUM(id, name) OST_ISA_##id,
    OST_ISA_LIST(OST_ISA_ENUM)
#undef OST_ISA_ENUM
    OST_ISA_COUNT
} ost_isa;

/*
 * The features that an x86-64 machine reports by CPUID. The registers of absent leaves are 0. If leaf 1 does not set
 * OSXSAVE, which allows XGETBV, `xcr0` is 0.
 */
typedef struct ost_isa_cpuid {
    uint32_t leaf1_c;
    uint32_t leaf7_b, leaf7_c;
    uint32_t extended1_c; /* leaf 0x80000001 */
    uint32_t xcr0;        /* XCR0: bit mask of the register sets that the operating system saves */
} ost_isa_cpuid;

/*
 * Returns the highest x86 level that a machine with these features can run. A level also requires that the operating
 * system saves the registers of that level.
 */
ost_isa ost_isa_decide(const ost_isa_cpuid *cpuid);

/*
 * Returns true if every machine of the level `isa` can also execute code of the level `level`.
 */
static inline bool ost_isa_includes(ost_isa isa, ost_isa level)
{
    return isa == level || level == OST_ISA_SCALAR || (isa != OST_ISA_NEON && level < isa);
}

const char *ost_isa_name(ost_isa isa);
/* Returns true if the library contains code of this level and the machine can execute it. */
bool ost_isa_available(ost_isa isa);
/* Returns the highest level for which ost_isa_available returns true. */
ost_isa ost_isa_best(void);
/*
 * Selects a level by its name, for example "avx2". NULL and "auto" select the level named by the environment
 * variable OSTEON_ISA, or the best level if the variable is not set. Returns OST_ERR_USAGE if the name is
 * unknown, and OST_ERR_UNAVAILABLE if this build or this machine does not support the level.
 */
ost_status ost_isa_choose(const char *name, ost_isa *out, ost_error *err);

#endif
