/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the rim of the glenoid's face on the maps of the surfaces before and after
 * the operation.
 *
 *   from the axis outward, in 72 directions:
 *
 *      w ^  highest - - - .--.        the rim: the last position within 1 mm of the highest
 *        |  ------.___.--'    |       position so far, before the surface falls by more than 3 mm,
 *        '--- r ----------> rim       ends, or rises by more than 3 mm to another surface
 *
 * Positions nearer than 6 mm to the axis are skipped, because the hole is there.
 */
#include "metrics/rim.h"

#include <math.h>

enum { MAP = OST_METRICS_MAP, WAYS = 72 };
#define NEAREST_MM 6.0
#define STEP_MM 0.25
#define FALL_MM 3.0
#define LEVEL_MM 1.0
#define LOWERED_MM 1.0
#define PI 3.14159265358979323846

typedef struct rim {
    double r[WAYS]; /* distance of the rim from the axis; NAN if the rim is not on the map */
} rim;

/*
 * Returns the index of the map cell at the distance r from the axis in a direction. Returns -1 if there is no such
 * cell.
 */
static int cell(int way, double r)
{
    const double angle = way * 2 * PI / WAYS;
    const long x = lrint(r * cos(angle) / OST_METRICS_PITCH_MM) + MAP / 2,
               y = lrint(r * sin(angle) / OST_METRICS_PITCH_MM) + MAP / 2;
    return x >= 0 && y >= 0 && x < MAP && y < MAP ? (int)(x + MAP * y) : -1;
}

static double trace(const float *surface, int way)
{
    double highest = INFINITY, last = NAN;
    for (double r = NEAREST_MM;; r += STEP_MM) {
        const int at = cell(way, r);
        if (at < 0)
            return NAN;
        const double w = (double)surface[at];
        if (isnan(w) || w > highest + FALL_MM || w < highest - FALL_MM)
            if (isnan(w) || isfinite(highest))
                return last;
        highest = fmin(highest, w);
        last = w <= highest + LEVEL_MM ? r : last;
    }
}

/*
 * Returns the extent of the face along a direction, from rim to rim. On each side of the axis, considers the rim points
 * within 30 degrees of the direction, and uses the one that is farthest along the direction. Returns NAN if one of the
 * sides has no such point on the map.
 */
static double across(const rim *edge, int way)
{
    double most[2] = {NAN, NAN};
    for (int side = 0; side < 2; side++)
        for (int d = -WAYS / 12; d <= WAYS / 12; d++) {
            const double r = edge->r[(way + side * WAYS / 2 + d + WAYS) % WAYS] * cos(d * 2 * PI / WAYS);
            if (!isnan(r))
                most[side] = isnan(most[side]) ? r : fmax(most[side], r);
        }
    return most[0] + most[1];
}

void ost_metrics_rim(ost_metrics *m)
{
    rim before, after;
    int seen = 0, lowered = 0;
    for (int k = 0; k < WAYS; k++) {
        before.r[k] = trace(m->before_mm, k);
        after.r[k] = trace(m->after_mm, k);
        if (isnan(before.r[k]))
            continue;
        /* If no rim is found after the operation, the rim counts as lowered in this direction. */
        const double down = isnan(after.r[k])
                                ? NAN
                                : (double)m->after_mm[cell(k, after.r[k])] - (double)m->before_mm[cell(k, before.r[k])];
        seen++;
        lowered += isnan(down) || down > LOWERED_MM;
        m->rim_lowered_mm = isnan(down) ? m->rim_lowered_mm : fmax(m->rim_lowered_mm, down);
    }
    m->rim_seen_percent = 100.0 * seen / WAYS;
    m->rim_lowered_percent = seen ? 100.0 * lowered / seen : 0;
    m->width_before_mm = across(&before, 0);
    m->width_after_mm = across(&after, 0);
    m->height_before_mm = across(&before, WAYS / 4);
    m->height_after_mm = across(&after, WAYS / 4);
}
