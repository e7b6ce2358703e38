/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

/*
 * Contract that replaces ost_rhe_div. It asserts d >= 1 and 0 <= n < 2^54, and returns any quotient from 0
 * to quotient_most.
 */
static int64_t quotient_most;

static int64_t snap_quotient(int64_t n, int64_t d)
{
    ASSERT(d >= 1);
    ASSERT(n >= 0 && n < INT64_C(1) << 54);
    int64_t q = nondet_int64();
    ASSUME(q >= 0 && q <= quotient_most);
    return q;
}
#define ost_rhe_div(n, d) snap_quotient(n, d)
#include "core/mesh_snap.c"
#undef ost_rhe_div

/*
 * Proves for one axis that snap does not overflow for any vertex coordinate p. The grid has at most 4096 voxels, each
 * voxel is at most 100 mm wide, and the grid lies within 8 m of the origin.
 */
void mesh_snap(void)
{
    const int32_t dim = any32(1, 4096);
    const int f = any32(1, 10);
    const ost_pm voxel = nondet_int64(), corner = any64(LENGTH << 2 * WIDER);
    ASSUME(voxel >= 1000000 && voxel <= INT64_C(100000000000));
    ASSUME(corner + dim * voxel <= LENGTH << 2 * WIDER);
    ASSUME(dim << f <= 1 << 20);
    quotient_most = (int64_t)dim << f;
    int32_t out;
    const ost_pm p = nondet_int64();
#ifdef WIDE
    ASSUME(p >= corner && p - corner <= dim * voxel);
    out = (int32_t)snap_quotient((p - corner) << f, voxel);
#else
    if (snap(p, corner, voxel, dim, f, &out))
        ASSERT(out >= 0 && out <= 1 << 20);
#endif
}

/*
 * Proves that has_area does not overflow for edges up to 2^20, and that its products are at most 2^40.
 */
void mesh_area(void)
{
    int32_t p[3][3];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            p[i][a] = any32(0, (1 << 20) << WIDER);
    (void)has_area(p[0], p[1], p[2]);
    int64_t u[3], v[3];
    for (int a = 0; a < 3; a++) {
        u[a] = (int64_t)p[1][a] - p[0][a];
        v[a] = (int64_t)p[2][a] - p[0][a];
    }
    BOUNDED(u[1] * v[2], INT64_C(1) << 40);
}
