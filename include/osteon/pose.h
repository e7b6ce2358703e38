/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pose transforms the tool's frame to the bone's (docs/spec/arithmetic.md, AR-POSE):
 *
 *     p_bone = R(q) p_tool + t          Hamilton convention, active rotation
 *
 * It is quantised once, when a device or a file is read, and has the same integers
 * from then on: live, recorded, replayed, on every backend.
 *
 *   t   picometres, at most 8 m on each axis
 *   q   w, x, y, z times 2^30, RHE, never renormalised; | |q| - 1 | <= 1e-3
 *       when read (an interpolated pose may be shorter, see event.h)
 *
 * In the thesis a pose is that of the centre of the tool's box, which depends on the
 * tool's resolution; here it does not (docs/design/thesis-notes.md).
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

/* Returns the pose without translation and rotation. */
OST_API ost_pose ost_pose_identity(void);

/*
 * Makes a pose from t_mm = x, y, z in millimetres and q = w, x, y, z, all by their shortest decimals.
 * Returns OST_ERR_RANGE if a number is NaN or out of range, or if the length of q is not near 1.
 */
OST_API ost_status ost_pose_from_doubles(const double t_mm[3], const double q[4], ost_pose *out, ost_error *err);

/* Makes a pose from decimals as written, without converting them to binary floats. */
OST_API ost_status ost_pose_from_decimals(const ost_decimal t_mm[3], const ost_decimal q[4], ost_pose *out,
                                          ost_error *err);

/* Returns OST_ERR_RANGE unless every component of t is within 8 m and | |q| - 1 | <= 1e-3. */
OST_API ost_status ost_pose_check(const ost_pose *pose, ost_error *err);

/* Converts a pose to the nearest doubles, only for pictures and forces. */
OST_API void ost_pose_to_doubles(const ost_pose *pose, double t_mm[3], double q[4]);

/*
 * Computes the quaternion, w x y z, of the rotation matrix with these columns, for
 * devices and cameras that provide matrices.  The columns must be orthonormal;
 * otherwise the length of the quaternion is not 1.
 */
OST_API void ost_quaternion_of_columns(const double columns[3][3], double q[4]);

#ifdef __cplusplus
}
#endif
#endif
