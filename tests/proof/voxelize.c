/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "cpu/ref/voxelize.c"

enum { LATTICE = 1 << 20 };

static void any_vertex(int32_t v[3])
{
    for (int a = 0; a < 3; a++)
        v[a] = any32(0, LATTICE << WIDER);
}

/* |E| <= 2^41: two products of differences up to 2^20. */
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
