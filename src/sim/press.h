/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the path glenoid-press: the target positions of a hand that reams for a given time.
 *
 *   depth   .                            sweep, seen along the axis
 *   -2 mm  |\  0.5 s: pressed in              .-----.
 *          | \                               (   x   )  an ellipse around the centre, period 6 s;
 *   12 mm  |  '-.   .-.   .-.                 '-----'   the tool is tilted by 3 degrees, period 2.5 s
 *          |     '-'   '-'   '-  deeper by 0.15 mm/s, to 24 mm; up and down by 1.5 mm, period 4 s
 *
 * The tool follows the target as far as the bone allows, and the spring between hand and tool determines the force.
 * The target lies far behind the face, so that the hand presses the tool into the bone. In dense bone, the tool
 * needs half a minute to reach the target. Afterwards, the motion along the ellipse and the tilt move the tool into
 * new bone.
 *
 * Each of the three periodic motions is a point on the unit circle, stored as the complex number c + i s. In each tick,
 * this number is multiplied by (p + i) / |p + i|, where p depends on the period. The code needs only + - * / and sqrt.
 */
#ifndef OST_SIM_PRESS_H
#define OST_SIM_PRESS_H

#include <osteon/length.h>

typedef struct press_wheel {
    double c, s;    /* current point on the unit circle */
    double step[2]; /* cosine and sine of the rotation per tick */
} press_wheel;

typedef struct press_load {
    press_wheel breath, sweep, wobble;
    double share; /* weight of the periodic motions, 0 to 1; it increases gradually */
    /*
     * Current values. `depth` is in mm from the face along the axis, and `across` is the offset in mm across the
     * axis. `lean` contains half of the tool's tilt angles about the x and y axes of its frame, in radians.
     */
    double depth, across[2], lean[2];
} press_load;

void ost_press_begin(press_load *load);
/* Advances the hand to tick k. Must be called for every tick in order, starting at tick 0. */
void ost_press_go_on(press_load *load, int64_t k);

#endif
