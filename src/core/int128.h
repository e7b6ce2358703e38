/* SPDX-License-Identifier: Apache-2.0 */
/* Converts between ost_int128 (event.h), which is independent of the compiler, and the compiler's 128-bit type. */
#ifndef OST_CORE_INT128_H
#define OST_CORE_INT128_H

#include <osteon/event.h>

#include "core/integer.h"

static inline ost_i128 ost_i128_of(ost_int128 value)
{
    return value.high * ((ost_i128)1 << 64) + value.low;
}

static inline ost_int128 ost_int128_of(ost_i128 value)
{
    return (ost_int128){.low = (uint64_t)value, .high = (int64_t)(value >> 64)};
}

#endif
