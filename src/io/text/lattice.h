/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the spacing of a CT text from its coordinates (docs/spec/arithmetic.md, AR-CT-3).
 *
 * An axis has m distinct coordinates c_0 < c_1 < ... < c_(m-1), written as multiples of a unit u (0.0001 mm if four
 * digits follow the point). They are points of a lattice with the origin o and the spacing s, each with a rounding
 * error e_i:
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
 * (Proof of =>: subtract o. Proof of <=: let o be the mean of the maximum and the minimum.)
 */
#ifndef OST_IO_LATTICE_H
#define OST_IO_LATTICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/grid.h>

/*
 * Units are numbered by their decimal place: the last digit of a coordinate with d decimal places has unit d + 3. Unit
 * 0 is 10^3 mm, and unit 12 is one picometre.
 */
enum { OST_LATTICE_UNITS = 13, OST_LATTICE_UNIT_PLACES = 3 };

typedef struct ost_lattice_axis {
    char name;            /* name of the axis: 'x', 'y' or 'z' */
    size_t count;         /* 1 <= count <= OST_DIM_MAX */
    const ost_pm *value;  /* distinct values in ascending order */
    const int64_t *line;  /* for each value, the line in which the value occurs first */
    uint32_t units;       /* set of the units that occur; bit n is unit number n */
    /* true if a coordinate has more than nine decimal places and was rounded, by at most half a picometre */
    bool rounded;
} ost_lattice_axis;

/*
 * Finds the spacing of each axis a with spacing[a] == 0; axes[a] is not read for other axes. Returns OST_ERR_INPUT
 * if no spacing or more than one fits; the message names the axis, the coordinate and the line, and suggests passing
 * the spacing as an option.
 */
ost_status ost_lattice_find(const char *path, const ost_lattice_axis axes[3], ost_pm spacing[3], ost_error *err);

#endif
