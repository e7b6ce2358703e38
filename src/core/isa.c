/* SPDX-License-Identifier: Apache-2.0 */
#include "core/isa.h"

#include "config.h"

static const char *const names[OST_ISA_COUNT] = {
#define OST_ISA_NAME(id, name) name,
    OST_ISA_LIST(OST_ISA_NAME)
#undef OST_ISA_NAME
};

const char *ost_isa_name(ost_isa isa)
{
    return (unsigned)isa < OST_ISA_COUNT ? names[isa] : "unknown";
}

enum {
    LEAF1_C = 1 << 23 | 1 << 28,                   /* POPCNT, AVX */
    OSXSAVE = 1 << 27,                             /* leaf 1, ECX: the operating system has enabled XGETBV */
    EXTENDED1_C = 1 << 5,                          /* LZCNT */
    LEAF7_B_AVX2 = 1 << 3 | 1 << 5 | 1 << 8,       /* BMI1, AVX2, BMI2 */
    LEAF7_C_VBMI = 1 << 1,                         /* AVX512_VBMI */
    /* XCR0 bits: the operating system saves XMM registers and the upper halves of YMM registers */
    YMM_SAVED = 0x06,
    /* XCR0 bits: the operating system also saves the opmasks, the upper halves of ZMM0-15, and ZMM16-31 */
    ZMM_SAVED = 0xe6,
};
#define LEAF7_B_AVX512                                                                                                 \
    (UINT32_C(1) << 16 | UINT32_C(1) << 17 | UINT32_C(1) << 28 | UINT32_C(1) << 30 |                                   \
     UINT32_C(1) << 31) /* AVX-512 F, DQ, CD, BW and VL */

static bool all(uint32_t value, uint32_t bits)
{
    return (value & bits) == bits;
}

ost_isa ost_isa_decide(const ost_isa_cpuid *cpuid)
{
    if (!all(cpuid->leaf1_c, LEAF1_C | OSXSAVE) || !all(cpuid->xcr0, YMM_SAVED) ||
        !all(cpuid->extended1_c, EXTENDED1_C) || !all(cpuid->leaf7_b, LEAF7_B_AVX2))
        return OST_ISA_SCALAR;
    if (!all(cpuid->xcr0, ZMM_SAVED) || !all(cpuid->leaf7_b, LEAF7_B_AVX512))
        return OST_ISA_AVX2;
    return all(cpuid->leaf7_c, LEAF7_C_VBMI) ? OST_ISA_AVX512VBMI : OST_ISA_AVX512;
}

#if defined __x86_64__

#include <cpuid.h>

static ost_isa detected(void)
{
    unsigned a, b, c, d;
    ost_isa_cpuid cpuid = {0};
    if (__get_cpuid(1, &a, &b, &c, &d))
        cpuid.leaf1_c = c;
    if (__get_cpuid(0x80000001, &a, &b, &c, &d))
        cpuid.extended1_c = c;
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d)) {
        cpuid.leaf7_b = b;
        cpuid.leaf7_c = c;
    }
    if (cpuid.leaf1_c & OSXSAVE)
        __asm__ volatile("xgetbv" : "=a"(cpuid.xcr0), "=d"(d) : "c"(0));
    return ost_isa_decide(&cpuid);
}

bool ost_isa_available(ost_isa isa)
{
    switch (isa) {
    case OST_ISA_SCALAR:
        return true;
    case OST_ISA_AVX2:
        return HAVE_AVX2_BUILD && isa <= detected();
    case OST_ISA_AVX512:
        return HAVE_AVX512_BUILD && isa <= detected();
    case OST_ISA_AVX512VBMI:
        return HAVE_AVX512VBMI_BUILD && isa <= detected();
    case OST_ISA_NEON:
    case OST_ISA_COUNT:
        break;
    }
    return false;
}

#else

/* Every AArch64 system that runs Linux has Advanced SIMD, so nothing is tested at run time. */
bool ost_isa_available(ost_isa isa)
{
    return isa == OST_ISA_SCALAR || (isa == OST_ISA_NEON && HAVE_NEON_BUILD);
}

#endif
