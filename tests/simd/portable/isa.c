/* SPDX-License-Identifier: Apache-2.0 */
/* Replaces src/core/isa.c: every machine runs portable kernels of every level. */
#include "core/isa.h"

const char *ost_isa_name(ost_isa isa)
{
    static const char *const names[OST_ISA_COUNT] = {
#define OST_ISA_NAME(id, name) name,
        OST_ISA_LIST(OST_ISA_NAME)
#undef OST_ISA_NAME
    };
    return (unsigned)isa < OST_ISA_COUNT ? names[isa] : "unknown";
}

bool ost_isa_available(ost_isa isa)
{
    return (unsigned)isa < OST_ISA_COUNT;
}
