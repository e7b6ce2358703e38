/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A shell in the bone: which of its points meet bone at a pose.
 *
 *   The points stay in the tool's frame, where all that is known of them
 *   beforehand stays as it is; forces and speeds are turned into it.  Only
 *   the place in the bone's grid is new in every tick: one affine map, four
 *   points at once, no division and no call.  What follows is done for those
 *   that touch alone.  A tool whose ball is beside the grid asks nothing.
 *
 * Lengths in metres.
 */
#ifndef OST_FORCE_CONTACT_H
#define OST_FORCE_CONTACT_H

#include <osteon/force.h>

#define OST_M_PER_PM 1e-12
#define OST_RIGID 1e12 /* N s/m^3: of a point that does not cut */

/* A tool's points, component by component; zeros behind the last. */
typedef struct contact_shell {
    size_t count;
    float at[3][OST_SHELL_MAX], inward[3][OST_SHELL_MAX];
    float outside[3][OST_SHELL_MAX]; /* a voxel outward: where a point looks for bone */
    float against[2][OST_SHELL_MAX]; /* x, y of the direction against the spin */
    float spin[OST_SHELL_MAX];       /* m/s */
    float area[OST_SHELL_MAX];
    float give[OST_SHELL_MAX];       /* N s/m: what it answers to its advance in bone of reference density */
    bool cutting[OST_SHELL_MAX];     /* it cuts: it can, and the tool turns */
    bool edge[OST_SHELL_MAX];        /* it can cut */
    double reach;                    /* of the farthest from the tool's origin, with what is outside */
} contact_shell;

/* Where the tool's frame is. */
typedef struct contact_pose {
    double turn[3][3]; /* from the tool's frame into the bone's */
    double at[3];
} contact_pose;

/* The points that touch, and what they touch. */
typedef struct contact {
    size_t count;
    uint16_t which[OST_SHELL_MAX];
    int16_t density[OST_SHELL_MAX];
    double depth[OST_SHELL_MAX];    /* of the layer, pressed together (instant) */
    /* Scratch: where points are in voxels from the tool's origin, in which voxels, and what is there. */
    float place[3][OST_SHELL_MAX];
    int32_t voxel[3][OST_SHELL_MAX];
    int16_t found[OST_SHELL_MAX];
} contact;

double ost_dot(const double a[3], const double b[3]);
void ost_cross(const double a[3], const double b[3], double out[3]);
/* q as w, x, y, z, of any length but 0. */
void ost_turn_of(const double q[4], double turn[3][3]);
void ost_into_bone(const contact_pose *pose, const double v[3], double out[3]);
void ost_into_tool(const contact_pose *pose, const double v[3], double out[3]);

/* spacing is the bone's. */
void ost_contact_shell_make(const ost_shell *shell, const ost_force_params *params, double spacing, contact_shell *out);
/* Sets what depends on the tool's speed, params->speed. */
void ost_contact_shell_speed(contact_shell *shell, const ost_force_params *params);
/* The points that find bone a voxel outward. */
ost_status ost_contact_touch(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, contact *c, ost_error *err);
/*
 * How deep the point that lies layer outward is in bone, along the inward
 * normal, up to twice the layer; and the density where it begins.
 */
ost_status ost_contact_press(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, double layer, contact *c, ost_error *err);

#endif
