/* SPDX-License-Identifier: Apache-2.0 */
/*
 * glenoid-press: what a hand wants that reams for as long as it is asked to.
 *
 *   depth   .                            sweep, seen along the axis
 *   -2 mm  |\  0.5 s: pressed in              .-----.
 *          | \                               (   x   )  an ellipse round the centre in 6 s
 *   12 mm  |  '-.   .-.   .-.                 '-----'   and the tool leans 3 degrees, round in 2.5 s
 *          |     '-'   '-'   '-  deeper by 0.15 mm/s, to 24 mm; up and down by 1.5 mm in 4 s
 *
 * It is a wish: the tool follows as far as the bone lets it, and what the
 * spring between hand and tool holds meanwhile is the force.  So the wish
 * begins well behind the face: in dense bone the tool is on its way there for
 * half a minute, and what sweeps and wobbles find new bone afterwards.
 *
 * Each of the three periods is a point that goes round a circle by a
 * recurrence, (c, s) * (p + i) / |p + i|, so only + - * / and sqrt are used.
 */
#ifndef OST_SIM_PRESS_H
#define OST_SIM_PRESS_H

#include <osteon/length.h>

typedef struct press_wheel {
    double c, s;    /* on the unit circle */
    double step[2]; /* a tick's turn */
} press_wheel;

typedef struct press_hand {
    press_wheel breath, sweep, wobble;
    double share; /* of sweep and wobble: they begin softly */
    /* Now: mm along the axis from the face, mm across it, and the axis' lean in half radians, about x and y of the tool's frame. */
    double depth, across[2], lean[2];
} press_hand;

void press_begin(press_hand *hand);
/* To tick k, one after the other from 0. */
void press_go_on(press_hand *hand, int64_t k);

#endif
