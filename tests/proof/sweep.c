/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "core/divider.h"
#include "core/rotation.h"

static int64_t between_quotient(int64_t n, int64_t d)
{
    ASSERT(d >= 1 && d <= 4096);
    BOUNDED(n, INT64_C(1) << 56);
    return 0;
}

#define ost_rhe_div(n, d) between_quotient(n, d)
#include "core/sweep.c"

void sweep_dot(void)
{
    const ost_pose a = {.qw = (int32_t)any64(QUATERNION),
                        .qx = (int32_t)any64(QUATERNION),
                        .qy = (int32_t)any64(QUATERNION),
                        .qz = (int32_t)any64(QUATERNION)};
    const ost_pose b = {.qw = (int32_t)any64(QUATERNION),
                        .qx = (int32_t)any64(QUATERNION),
                        .qy = (int32_t)any64(QUATERNION),
                        .qz = (int32_t)any64(QUATERNION)};
    (void)dot(&a, &b);
}

void sweep_between(void)
{
    const int64_t n = any32(1, 4096), k = any32(1, 4096);
    ASSUME(k <= n);
    (void)between(any64(LENGTH << 2 * WIDER), any64(LENGTH << 2 * WIDER), k, n);
}

/*
 * Proves the bounds of the comparisons in ost_sweep_count. The proof uses a copy of these
 * comparisons, because the originals are in a loop of 4096 iterations.
 */
void sweep_compared(void)
{
    const ost_i128 d = nondet_int128(), p = nondet_int64(), n = any32(1, 4097),
                   voxel = any64(INT64_C(100000000000) << 15 * WIDER);
    ASSUME(p >= 0 && p <= (ost_i128)1 << (61 + WIDER));
    ASSUME(d >= 0 && d < (ost_i128)1 << 93);
    const ost_i128 squared = 2 * p * p, needed = 4 * d, given = n * n * (voxel * voxel);
    ASSERT(squared <= (ost_i128)1 << 123);
    ASSERT(needed < (ost_i128)1 << 96);
    ASSERT(given >= 0 && given < (ost_i128)1 << 98);
}
