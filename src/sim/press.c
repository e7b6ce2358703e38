/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "sim/press.h"

#include <math.h>

/*
 * Durations are in ticks of 1 ms. A press_wheel with the parameter p rotates by atan(1/p) per tick, which is one
 * revolution in about 2 pi p ticks.
 */
enum { PRESS_TICKS = 500, SOFT_TICKS = 2000, BREATH_P = 637, SWEEP_P = 955, WOBBLE_P = 398 };

#define BEGIN -2.0     /* depth at tick 0 in mm, at which the tool does not touch the rim of the face */
#define PRESSED 12.0   /* depth after PRESS_TICKS in mm */
#define CREEP 1.5e-4   /* increase in depth in mm per tick */
#define DEEPEST 24.0
#define BREATH 1.5    /* amplitude of the motion along the axis in mm */
#define SWEEP_X 4.0   /* semi-axis of the ellipse along x in mm; SWEEP_Y is the semi-axis along y */
#define SWEEP_Y 6.0
#define LEAN 0.0262   /* half of the tool's tilt of 3 degrees, in radians */

static press_wheel wheel(double p)
{
    const double length = sqrt(p * p + 1);
    return (press_wheel){1, 0, {p / length, 1 / length}};
}

static void turn(press_wheel *w)
{
    const double c = w->c * w->step[0] - w->s * w->step[1], s = w->c * w->step[1] + w->s * w->step[0],
                 length = sqrt(c * c + s * s);
    w->c = c / length;
    w->s = s / length;
}

void ost_press_begin(press_load *load)
{
    *load = (press_load){.breath = wheel(BREATH_P), .sweep = wheel(SWEEP_P), .wobble = wheel(WOBBLE_P)};
}

void ost_press_go_on(press_load *load, int64_t k)
{
    load->depth = k < PRESS_TICKS ? BEGIN + (PRESSED - BEGIN) * (double)k / PRESS_TICKS
                                  : PRESSED + CREEP * (double)(k - PRESS_TICKS);
    if (k < PRESS_TICKS)
        return;
    if (load->depth > DEEPEST)
        load->depth = DEEPEST;
    /* The periodic motions start at the depth at which pressing ended. The motion along the axis begins inward. */
    turn(&load->breath);
    turn(&load->sweep);
    turn(&load->wobble);
    load->share = k < SOFT_TICKS ? (double)(k - PRESS_TICKS) / (SOFT_TICKS - PRESS_TICKS) : 1;
    load->depth += load->share * BREATH * load->breath.s;
    load->across[0] = load->share * SWEEP_X * load->sweep.c;
    load->across[1] = load->share * SWEEP_Y * load->sweep.s;
    load->lean[0] = load->share * LEAN * load->wobble.c;
    load->lean[1] = load->share * LEAN * load->wobble.s;
}
