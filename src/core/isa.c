/* SPDX-License-Identifier: Apache-2.0 */
#include "core/isa.h"

#include <stdlib.h>
#include <string.h>

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

#if defined __x86_64__

#include <cpuid.h>

enum {
    SSE_AVX_STATE = 0x06,    /* XCR0: XMM and YMM are saved by the system */
    AVX512_STATE = 0xe6,     /* and opmask, upper halves of ZMM0-15, ZMM16-31 */
};

static unsigned saved_state(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

static bool all(unsigned value, unsigned bits)
{
    return (value & bits) == bits;
}

static bool detect(ost_isa isa)
{
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !all(c, bit_OSXSAVE | bit_AVX | bit_POPCNT) || !all(saved_state(), SSE_AVX_STATE))
        return false;
    if (!__get_cpuid(0x80000001, &a, &b, &c, &d) || !all(c, bit_LZCNT))
        return false;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || !all(b, bit_AVX2 | bit_BMI | bit_BMI2))
        return false;
    if (isa == OST_ISA_AVX2)
        return true;
    if (!all(saved_state(), AVX512_STATE) || !all(b, bit_AVX512F | bit_AVX512BW | bit_AVX512DQ | bit_AVX512VL | bit_AVX512CD))
        return false;
    return isa == OST_ISA_AVX512 || all(c, bit_AVX512VBMI);
}

bool ost_isa_available(ost_isa isa)
{
    switch (isa) {
    case OST_ISA_SCALAR:
        return true;
    case OST_ISA_AVX2:
        return HAVE_AVX2_BUILD && detect(isa);
    case OST_ISA_AVX512:
        return HAVE_AVX512_BUILD && detect(isa);
    case OST_ISA_AVX512VBMI:
        return HAVE_AVX512VBMI_BUILD && detect(isa);
    case OST_ISA_NEON:
    case OST_ISA_COUNT:
        break;
    }
    return false;
}

#else

/* Advanced SIMD is part of every AArch64 system that runs Linux. */
bool ost_isa_available(ost_isa isa)
{
#if defined __aarch64__
    return isa == OST_ISA_SCALAR || isa == OST_ISA_NEON;
#else
    return isa == OST_ISA_SCALAR;
#endif
}

#endif

ost_isa ost_isa_best(void)
{
    for (int isa = OST_ISA_COUNT - 1; isa > OST_ISA_SCALAR; isa--)
        if (ost_isa_available((ost_isa)isa))
            return (ost_isa)isa;
    return OST_ISA_SCALAR;
}

ost_status ost_isa_choose(const char *name, ost_isa *out, ost_error *err)
{
    const char *from = "";
    if (!name || strcmp(name, "auto") == 0) {
        name = getenv("OSTEON_ISA");
        from = "OSTEON_ISA: ";
    }
    if (!name || !*name || strcmp(name, "auto") == 0) {
        *out = ost_isa_best();
        return OST_OK;
    }
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        if (strcmp(names[isa], name) == 0) {
            if (!ost_isa_available((ost_isa)isa))
                return ost_fail(err, OST_ERR_UNAVAILABLE, "%sinstruction set '%s' cannot be used here; osteon devices says what can", from, name);
            *out = (ost_isa)isa;
            return OST_OK;
        }
    return ost_fail(err, OST_ERR_USAGE, "%sthere is no instruction set '%.40s'; known are auto, scalar, avx2, avx512, avx512vbmi and neon",
                    from, name);
}
