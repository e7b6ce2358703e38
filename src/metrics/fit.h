/* SPDX-License-Identifier: Apache-2.0 */
/* Least squares: a sphere through points. */
#ifndef OST_METRICS_FIT_H
#define OST_METRICS_FIT_H

#include <stdbool.h>
#include <stddef.h>

/* Algebraic: |p|^2 = 2 c.p + k is linear in c and k. False when the points do not fix a sphere. */
bool ost_fit_sphere(const double (*points)[3], size_t count, double centre[3], double *radius);

#endif
