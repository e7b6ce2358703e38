/* SPDX-License-Identifier: Apache-2.0 */
#include "force/vibration.h"

#include <math.h>

#define TURN 6.283185307179586476925286766559

void ost_sin_cos(double angle, double *sine, double *cosine)
{
    /*
     * x is a sixteenth of the angle modulo complete turns, so |x| is at most 0.2. The series are computed for x, and
     * the angle is then doubled four times.
     */
    const double x = (angle - TURN * rint(angle / TURN)) / 16, q = x * x;
    double s = x * (1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72))));
    double c = 1 - q / 2 * (1 - q / 12 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90))));
    for (int i = 0; i < 4; i++) {
        const double twice = 2 * s * c;
        c = c * c - s * s;
        s = twice;
    }
    *sine = s;
    *cosine = c;
}
