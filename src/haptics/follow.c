/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/follow.h"

#include <math.h>

#include "core/quaternion.h"

static const double FOLLOW = 0.0645;          /* fraction of the remaining distance per tick: 1 - exp(-1 ms / 15 ms) */
static const double TURN = 0.0188;            /* maximum rotation per tick in radians: three revolutions per second */

static void approach_position(haptic_follow *f, const double to[3], double step_m)
{
    double d[3], length = 0;
    for (int a = 0; a < 3; a++) {
        d[a] = (to[a] - f->at[a]) * FOLLOW;
        length += d[a] * d[a];
    }
    length = sqrt(length);
    for (int a = 0; a < 3; a++)
        f->at[a] += length > step_m ? d[a] * step_m / length : d[a];
}

/* Rotates the tool toward `to` along the shorter arc. The rotation is the fraction FOLLOW of the angle, but at most
   TURN. The quaternions q and -q denote the same orientation. */
static void approach_turn(haptic_follow *f, const double to[4])
{
    double cosine = 0;
    for (int i = 0; i < 4; i++)
        cosine += f->q[i] * to[i];
    const double sign = cosine < 0 ? -1 : 1, angle = 2 * acos(fmin(1, fabs(cosine)));
    const double share = angle * FOLLOW > TURN ? TURN / angle : FOLLOW;
    for (int i = 0; i < 4; i++)
        f->q[i] += (sign * to[i] - f->q[i]) * share;
    ost_quaternion_unit(f->q);
}

void ost_haptic_follow_tick(haptic_follow *f, const double to[3], const double toward[4], double step_m)
{
    approach_position(f, to, step_m);
    approach_turn(f, toward);
}
