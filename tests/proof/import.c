/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "cpu/ref/import.c"

static ost_pm any_spacing(void)
{
    const ost_pm spacing = nondet_int64();
    ASSUME(spacing >= 1000000 && spacing <= INT64_C(100000000000));
    return spacing;
}

/* Proves that on_lattice and its quotient do not overflow for sample and origin coordinates of up to 8 m. */
void import_lattice(void)
{
    (void)on_lattice(any64(LENGTH << 19 * WIDER), any64(LENGTH << 19 * WIDER), any_spacing());
}

/* Proves that 8 * off, 3 * s and 10^6 * off do not overflow for any lattice point with off <= spacing / 2. */
void import_offset(void)
{
    const ost_pm spacing = any_spacing(), off = nondet_int64();
    ASSUME(off >= 0 && off <= spacing / 2 << 14 * WIDER);
    const lattice one = {nondet_int64(), off, spacing};
    const lattice at[3] = {one, one, one};
    (void)beyond(at, 3);
    (void)offset_ppm(at);
}
