/* SPDX-License-Identifier: Apache-2.0 */
/* Rotations of the tool as quaternions {w, x, y, z} of any length. */
#ifndef OST_FORCE_TURN_H
#define OST_FORCE_TURN_H

#include <osteon/pose.h>

/*
 * Computes the rotation from a to b as a vector in the bone's frame, along the axis of the rotation. The length of the
 * vector is twice the sine of half the angle.
 */
void ost_turn_between(const double a[4], const double b[4], double out[3]);
/* Multiplies q on the right by a rotation about z by `angle` in radians. The arrays q and `out` may be the same. */
void ost_turn_about_axis(const double q[4], double angle, double out[4]);
/* Copies the quaternion of a pose. */
void ost_turn_quaternion(const ost_pose *pose, double q[4]);

/*
 * Returns `angle` (rad), with its magnitude reduced by 64 complete turns if the magnitude exceeds 64 turns. A sum of
 * angles to which this function is applied stays bounded.
 */
double ost_turn_less_64(double angle);

#endif
