/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The vibration that a rotating tool causes while it cuts (optional):
 *
 *   A (vibration sin(teeth phi) z  +  runout (cos phi x + sin phi y))
 *
 * `vibration`, `teeth` and `runout` are parameters (ost_force_params).
 * phi is the angle by which the tool has rotated; x, y, z are the handle's axes.
 * A is the sum of the scaled normal forces of the cutting points, each multiplied
 * by the ratio of the bone's density to the reference density.  Dense bone therefore
 * causes more vibration, and air causes none.
 */
#ifndef OST_FORCE_VIBRATION_H
#define OST_FORCE_VIBRATION_H

/*
 * Computes sine and cosine using only + - * /, so that the results are the same on every machine. The
 * error is below 1e-9 for angles up to a few thousand turns.
 */
void ost_sin_cos(double angle, double *sine, double *cosine);

#endif
