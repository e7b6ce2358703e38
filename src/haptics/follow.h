/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Follows poses that arrive less often than ticks, for example once per frame. The tool approaches the newest pose with
 * a time constant of 15 ms and a maximum speed, so that its motion is smooth and can be swept.
 */
#ifndef OST_HAPTICS_FOLLOW_H
#define OST_HAPTICS_FOLLOW_H

#include <osteon/pose.h>

typedef struct haptic_follow {
    double at[3]; /* position in m */
    double q[4];  /* unit quaternion w x y z */
} haptic_follow;

/*
 * Advances by one tick of 1 ms toward a pose. The motion is at most step_m metres. The rotation takes the shorter arc
 * and is at most three revolutions per second.
 */
void ost_haptic_follow_tick(haptic_follow *f, const double to[3], const double toward[4], double step_m);

#endif
