/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vibration of the hand by a rotating tool while it cuts (optional):
 *
 *   A (vibration sin(teeth phi) z  +  runout (cos phi x + sin phi y))
 *
 * phi is the angle by which the tool has rotated; x, y, z are the handle's axes.
 * A is the sum of the scaled normal forces of the cutting points, each multiplied
 * by the ratio of its bone's density to the reference density: dense bone
 * vibrates more, and air not at all.
 */
#ifndef OST_FORCE_VIBRATION_H
#define OST_FORCE_VIBRATION_H

/*
 * Computes sine and cosine using only + - * /, so that results are the same everywhere;
 * accurate to 1e-9 for angles within some thousand turns.
 */
void ost_sin_cos(double angle, double *sine, double *cosine);

#endif
