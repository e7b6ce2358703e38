/* SPDX-License-Identifier: Apache-2.0 */
/* Computes AR-POSE-4 without a matrix: for every integer quaternion q, M v is the vector part of q v q*. */
#include "validation/dense/steps.h"

typedef struct quaternion {
    wide c[4]; /* w, x, y, z */
} quaternion;

/* Returns the Hamilton product, with i j = k, j k = i, k i = j. */
static quaternion product(const quaternion *p, const quaternion *q)
{
    static const struct {
        int to, sign;
    } unit[4][4] = {{{0, 1}, {1, 1}, {2, 1}, {3, 1}},
                    {{1, 1}, {0, -1}, {3, 1}, {2, -1}},
                    {{2, 1}, {3, -1}, {0, -1}, {1, 1}},
                    {{3, 1}, {2, 1}, {1, -1}, {0, -1}}};
    quaternion out = {{wide_of(0), wide_of(0), wide_of(0), wide_of(0)}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            const wide term = wide_times(p->c[i], q->c[j]);
            wide *to = &out.c[unit[i][j].to];
            *to = unit[i][j].sign > 0 ? wide_plus(*to, term) : wide_minus(*to, term);
        }
    return out;
}

void steps_turn(const ost_pose *pose, bool back, const wide v[3], wide out[3])
{
    const wide x = wide_of(pose->qx), y = wide_of(pose->qy), z = wide_of(pose->qz);
    const quaternion q = {{wide_of(pose->qw), x, y, z}},
                     conjugate = {{wide_of(pose->qw), wide_negated(x), wide_negated(y), wide_negated(z)}};
    const quaternion vector = {{wide_of(0), v[0], v[1], v[2]}};
    const quaternion half = product(back ? &conjugate : &q, &vector), all = product(&half, back ? &q : &conjugate);
    for (int a = 0; a < 3; a++)
        out[a] = all.c[a + 1];
}

wide steps_norm(const ost_pose *pose)
{
    const int32_t q[4] = {pose->qw, pose->qx, pose->qy, pose->qz};
    wide n = wide_of(0);
    for (int c = 0; c < 4; c++)
        n = wide_plus(n, wide_times(wide_of(q[c]), wide_of(q[c])));
    return n;
}
