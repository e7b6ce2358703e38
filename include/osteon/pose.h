/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pose transforms the tool's frame to the bone's frame (docs/spec/arithmetic.md, AR-POSE):
 *
 *     p_bone = R(q) p_tool + t          Hamilton convention, active rotation
 *
 * A pose is quantised once, when it is read from a device or a file. From then on, its integers do not change: they
 * are the same in a live operation, in its recording and replay, and on every backend.
 *
 *   t   picometres, at most 8 m on each axis
 *   q   w, x, y, z times 2^30, rounded half to even, never renormalised; | |q| - 1 | <= 1e-3
 *       when read (an interpolated pose may be shorter, see event.h)
 *
 * In the thesis a pose refers to the centre of the tool's box, which depends on the
 * resolution of the tool. Here a pose refers to the tool's frame and does not
 * depend on the resolution (docs/design/thesis-notes.md).
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_POSE_H
#define OSTEON_POSE_H

#include <osteon/length.h>

#ifdef __cplusplus
extern "C" {
#endif

#define OST_Q30_ONE (INT32_C(1) << 30)

/* A pose: the translation t and the quaternion (qw, qx, qy, qz) / 2^30, not necessarily of unit length. */
typedef struct ost_pose {
    ost_pm3 t;
    int32_t qw, qx, qy, qz;
} ost_pose;

/* Returns the identity: no translation and no rotation. */
OST_API ost_pose ost_pose_identity(void);

/*
 * Converts a position t_mm = x, y, z in millimetres and a quaternion q = w, x, y, z to a pose. Each double is converted
 * to the shortest decimal that reads back as this double. The decimal is then quantised. Returns OST_ERR_RANGE if a
 * number is NaN or out of range, or if the length of q is not near 1.
 */
OST_API ost_status ost_pose_from_doubles(const double t_mm[3], const double q[4], ost_pose *out, ost_error *err);

/* Converts decimals, as written in a string, to a pose. No binary floats are used in between. The errors are those of
 * ost_pose_from_doubles. */
OST_API ost_status ost_pose_from_decimals(const ost_decimal t_mm[3], const ost_decimal q[4], ost_pose *out,
                                          ost_error *err);

/* Returns OST_ERR_RANGE unless every component of t is within 8 m and | |q| - 1 | <= 1e-3. */
OST_API ost_status ost_pose_check(const ost_pose *pose, ost_error *err);

/* Converts a pose to the nearest doubles. Used only for pictures and forces. */
OST_API void ost_pose_to_doubles(const ost_pose *pose, double t_mm[3], double q[4]);

/*
 * Computes the quaternion w, x, y, z of the rotation matrix with the given columns. Used for devices and cameras
 * that provide matrices. If the columns are not orthonormal, the length of the quaternion is not 1.
 */
OST_API void ost_quaternion_of_columns(const double columns[3][3], double q[4]);

#ifdef __cplusplus
}
#endif
#endif
