/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which instruction sets this machine has, and which may be used.
 *
 *   detected  --  what CPU and operating system give (CPUID, XGETBV; on AArch64 all have NEON)
 *   allowed   --  detected, up to the level that was asked for: by a backend's
 *                 "isa=" option, else by the environment variable OSTEON_ISA
 *
 * A level is named after what it requires and includes the ones before it.
 * Code of a level runs only where its level is allowed, so an illegal
 * instruction is impossible however the program was built.
 */
#ifndef OST_CORE_ISA_H
#define OST_CORE_ISA_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

/*
 *   scalar      C alone (with the baseline of the build: SSE2 on x86-64)
 *   avx2        AVX2, BMI1, BMI2, LZCNT, POPCNT, FMA is not used
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
 * What an x86-64 machine says of itself; registers of leaves it does not have are 0.
 * xcr0 is 0 unless leaf 1 says that XGETBV may be asked (OSXSAVE).
 */
typedef struct ost_isa_cpuid {
    uint32_t leaf1_c;
    uint32_t leaf7_b, leaf7_c;
    uint32_t extended1_c; /* leaf 0x80000001 */
    uint32_t xcr0;        /* registers that the operating system saves */
} ost_isa_cpuid;

/* The highest x86 level that such a machine can run. An instruction set counts only when its registers are saved. */
ost_isa ost_isa_decide(const ost_isa_cpuid *cpuid);

const char *ost_isa_name(ost_isa isa);
/* Whether this machine, and this build, can run code of the level. */
bool ost_isa_available(ost_isa isa);
/* The highest available level. */
ost_isa ost_isa_best(void);
/*
 * The level to use: name ("avx2"; NULL or "auto" for the environment's, else the best).
 * OST_ERR_USAGE when there is no such level, OST_ERR_UNAVAILABLE when it does not run here.
 */
ost_status ost_isa_choose(const char *name, ost_isa *out, ost_error *err);

#endif
