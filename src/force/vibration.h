/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a tool's turning shakes the hand with, as long as it cuts (an option):
 *
 *   A (vibration sin(teeth phi) z  +  runout (cos phi x + sin phi y))
 *
 * phi is how far the tool has turned, x, y, z the handle's axes.  A is the
 * felt normal force of the points that cut, each times its bone's density over
 * the reference's: dense bone shakes more, and air not at all.
 */
#ifndef OST_FORCE_VIBRATION_H
#define OST_FORCE_VIBRATION_H

/* sin and cos of any angle, of + - * / alone, so the same everywhere; to 1e-9 for angles within some thousand turns. */
void ost_sin_cos(double angle, double *sine, double *cosine);

#endif
