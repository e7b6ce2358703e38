/* SPDX-License-Identifier: Apache-2.0 */
/*
 * glenoid-press: the target position of a hand that reams for as long as required.
 *
 *   depth   .                            sweep, seen along the axis
 *   -2 mm  |\  0.5 s: pressed in              .-----.
 *          | \                               (   x   )  an ellipse round the centre in 6 s
 *   12 mm  |  '-.   .-.   .-.                 '-----'   and the tool leans 3 degrees, round in 2.5 s
 *          |     '-'   '-'   '-  deeper by 0.15 mm/s, to 24 mm; up and down by 1.5 mm in 4 s
 *
 * The tool follows the target as far as the bone allows, and the spring between
 * hand and tool determines the force.  The target therefore starts well behind
 * the face: in dense bone the tool takes half a minute to get there, and sweeps
 * and wobbles reach new bone afterwards.
 *
 * Each of the three periodic motions is a point that moves on a circle by a
 * recurrence, (c, s) * (p + i) / |p + i|, so only + - * / and sqrt are used.
 */
#ifndef OST_SIM_PRESS_H
#define OST_SIM_PRESS_H

#include <osteon/length.h>

typedef struct press_wheel {
    double c, s;    /* on the unit circle */
    double step[2]; /* rotation per tick */
} press_wheel;

typedef struct press_load {
    press_wheel breath, sweep, wobble;
    double share; /* weight of sweep and wobble, which begin gradually */
    /*
     * Current values: mm along the axis from the face; mm across it; lean of the axis in half
     * radians, about x and y of the tool's frame.
     */
    double depth, across[2], lean[2];
} press_load;

void press_begin(press_load *load);
/* Advances the hand to tick k. Called for every tick in order, from 0. */
void press_go_on(press_load *load, int64_t k);

#endif
