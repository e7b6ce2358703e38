/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Selects a level by its name. The functions that detect the levels of the machine are in isa.c. They are separate,
 * because the tests in tests/simd/portable replace them: these tests compile the kernels with portable definitions of
 * the intrinsics, so every level can be executed on every machine.
 */
#include "core/isa.h"

#include <stdlib.h>
#include <string.h>

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
        if (strcmp(ost_isa_name((ost_isa)isa), name) == 0) {
            if (!ost_isa_available((ost_isa)isa))
                return ost_fail(err, OST_ERR_UNAVAILABLE,
                                "%sinstruction set '%s' is not available here; see osteon devices", from, name);
            *out = (ost_isa)isa;
            return OST_OK;
        }
    return ost_fail(err, OST_ERR_USAGE,
                    "%sunknown instruction set '%.40s'; expected auto, scalar, avx2, avx512, avx512vbmi or neon",
                    from, name);
}
