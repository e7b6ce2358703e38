/* SPDX-License-Identifier: Apache-2.0 */
/* Least-squares fit of a sphere to points. */
#ifndef OST_CORE_FIT_H
#define OST_CORE_FIT_H

#include <stdbool.h>
#include <stddef.h>

/*
 * Fits a sphere by the algebraic method: |p|^2 = 2 c.p + k is linear in the centre c and in k.
 * Returns false if the points do not determine a sphere.
 */
bool ost_fit_sphere(const double (*points)[3], size_t count, double centre[3], double *radius);

#endif
