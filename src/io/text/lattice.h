/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The spacing of a CT text, found from its coordinates (docs/arithmetic.md, AR-CT-3).
 *
 * One axis has m distinct coordinates c_0 < c_1 < ... < c_(m-1), written to a
 * unit u (0.0001 mm when four digits follow the point).  They are the points
 * of a lattice, each rounded to u:
 *
 *   c_i = o + k_i s + e_i,   |e_i| <= u / 2,   k_0 = 0
 *
 *   o      s      2s     3s            5s
 *   |------|------|------|------|------|
 *   c_0    c_1    c_2    c_3           c_4      k = 0 1 2 3 5 (a layer may be absent)
 *
 * A spacing s is feasible for steps k iff
 *
 *   max(c_i - k_i s) - min(c_i - k_i s) <= u                                (F)
 *
 * (=> : subtract o.  <= : put o in the middle between the two.)
 */
#ifndef OST_IO_LATTICE_H
#define OST_IO_LATTICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/grid.h>

/* Unit n is the worth of the last digit of a coordinate with n - 3 places: 10^3 mm for 0, a picometre for 12. */
enum { OST_LATTICE_UNITS = 13, OST_LATTICE_UNIT_PLACES = 3 };

typedef struct ost_lattice_axis {
    char name;            /* 'x', 'y', 'z' */
    size_t count;         /* 1 <= count <= OST_DIM_MAX */
    const ost_pm *value;  /* distinct, ascending */
    const int64_t *line;  /* where each was read first */
    uint32_t units;       /* bit n: unit n occurs */
    bool rounded;         /* some coordinate had more than nine places: its picometres are up to half a one off */
} ost_lattice_axis;

/*
 * Fills spacing[a] where it is 0 on entry; where it is not, axes[a] is not
 * looked at.  OST_ERR_INPUT, naming axis, coordinate and line, and asking for
 * the spacing, when none or several fit.
 */
ost_status ost_lattice_find(const char *path, const ost_lattice_axis axes[3], ost_pm spacing[3], ost_error *err);

#endif
