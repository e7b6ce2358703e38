/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A shell in the bone: finds the points of a tool that meet bone at a pose.
 *
 *   The points stay in the tool's frame, where their precomputed properties are
 *   constant; forces and velocities are rotated into that frame.  Only the
 *   positions in the bone's grid are computed in each tick: one affine map, four
 *   points at once, without a division or a call.  All further work is done only
 *   for the points that touch.  If the tool's bounding sphere lies outside the
 *   grid, no voxel is read.
 *
 * Lengths are in metres.
 */
#ifndef OST_FORCE_CONTACT_H
#define OST_FORCE_CONTACT_H

#include <osteon/force.h>

#define OST_M_PER_PM 1e-12
#define OST_RIGID 1e12 /* N s/m^3: resistance of a point that does not cut */

/* A tool's points, stored by component; zeros beyond the last. */
typedef struct contact_shell {
    size_t count;
    float at[3][OST_SHELL_MAX], inward[3][OST_SHELL_MAX];
    float outside[3][OST_SHELL_MAX]; /* a voxel outward: the position at which bone is sought */
    float against[2][OST_SHELL_MAX]; /* x and y of the direction against the rotation */
    float spin[OST_SHELL_MAX];       /* m/s */
    float area[OST_SHELL_MAX];
    float give[OST_SHELL_MAX];       /* N s/m: resistance to its advance in bone of reference density */
    bool cutting[OST_SHELL_MAX];     /* the point can cut and the tool rotates */
    bool edge[OST_SHELL_MAX];        /* the point can cut */
    double reach;                    /* largest distance of a point from the tool's origin, including `outside` */
} contact_shell;

/* The pose of the tool's frame. */
typedef struct contact_pose {
    double turn[3][3]; /* from the tool's frame to the bone's */
    double at[3];
} contact_pose;

/* The points that touch bone, and the density of the bone there. */
typedef struct contact {
    size_t count;
    uint16_t which[OST_SHELL_MAX];
    int16_t density[OST_SHELL_MAX];
    double depth[OST_SHELL_MAX];    /* compressed thickness of the layer (law instant) */
    /*
     * Scratch: positions of the points in voxels from the tool's origin, their voxels, and the
     * densities found.
     */
    float position[3][OST_SHELL_MAX];
    int32_t voxel[3][OST_SHELL_MAX];
    int16_t found[OST_SHELL_MAX];
} contact;

double ost_dot(const double a[3], const double b[3]);
void ost_cross(const double a[3], const double b[3], double out[3]);
/* q is w, x, y, z, of any length except 0. */
void ost_turn_of(const double q[4], double turn[3][3]);
void ost_into_bone(const contact_pose *pose, const double v[3], double out[3]);
void ost_into_tool(const contact_pose *pose, const double v[3], double out[3]);

/* Makes the points of `shell`. spacing is the bone's, in metres. */
void ost_contact_shell_make(const ost_shell *shell, const ost_force_params *params, double spacing, contact_shell *out);
/* Updates the values that depend on the tool's speed, params->speed. */
void ost_contact_shell_speed(contact_shell *shell, const ost_force_params *params);
/* Finds the points with bone a voxel outward. */
ost_status ost_contact_touch(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, contact *c,
                             ost_error *err);
/*
 * Finds the points with bone within `layer` of the surface. depth is how deep the position
 * `layer` outward of the point lies in bone, measured along the inward normal, at most twice
 * the layer; density is that of the first bone voxel.
 */
ost_status ost_contact_press(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, double layer,
                             contact *c, ost_error *err);

#endif
