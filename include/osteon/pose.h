/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pose takes the tool's frame into the bone's (docs/arithmetic.md, AR-POSE):
 *
 *     p_bone = R(q) p_tool + t          Hamilton convention, active rotation
 *
 * It is quantised once, when a device or a file is read, and is the same
 * integers ever after: live, recorded, replayed, on every backend.
 *
 *   t   picometres, |t| <= 8 m an axis
 *   q   w, x, y, z times 2^30, RHE, never renormalised; | |q| - 1 | <= 1e-3
 *       when read (an interpolated pose may be shorter, see event.h)
 *
 * The thesis' pose is the centre of the tool's box, which moves with the
 * resolution of the tool; ours does not (docs/thesis-notes.md).
 */
#ifndef OSTEON_POSE_H
#define OSTEON_POSE_H

#include <osteon/length.h>

#ifdef __cplusplus
extern "C" {
#endif

#define OST_Q30_ONE (INT32_C(1) << 30)

typedef struct ost_pose {
    ost_pm3 t;
    int32_t qw, qx, qy, qz;
} ost_pose;

OST_API ost_pose ost_pose_identity(void);

/* t_mm: x, y, z in millimetres, q: w, x, y, z; all by their shortest decimal. OST_ERR_RANGE on NaN, range or norm. */
OST_API ost_status ost_pose_from_doubles(const double t_mm[3], const double q[4], ost_pose *out, ost_error *err);

/* The same from decimals as written: no binary float in between. */
OST_API ost_status ost_pose_from_decimals(const ost_decimal t_mm[3], const ost_decimal q[4], ost_pose *out, ost_error *err);

/* OST_ERR_RANGE unless |t| and | |q| - 1 | <= 1e-3 hold. */
OST_API ost_status ost_pose_check(const ost_pose *pose, ost_error *err);

/* Nearest doubles, for pictures and forces only. */
OST_API void ost_pose_to_doubles(const ost_pose *pose, double t_mm[3], double q[4]);

/*
 * The quaternion, w x y z, of the rotation whose columns these are; for what
 * gives matrices, devices and cameras.  They are taken to be unit and upright
 * to each other: of others a quaternion comes whose length is not 1.
 */
OST_API void ost_quaternion_of_columns(const double columns[3][3], double q[4]);

#ifdef __cplusplus
}
#endif
#endif
