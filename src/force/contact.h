/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the points of a tool's shell that touch bone at a pose.
 *
 *   The points are stored in the tool's frame, where their properties are constant;
 *   forces and velocities are rotated into that frame.  Only the positions in the
 *   bone's grid are computed in each tick.  One affine map computes them for four
 *   points at a time, without divisions or calls.  All further work is done only for
 *   the points that touch bone.  If the tool's bounding sphere lies outside the grid,
 *   no voxel is read.
 *
 * Lengths are in metres.
 */
#ifndef OST_FORCE_CONTACT_H
#define OST_FORCE_CONTACT_H

#include <osteon/force.h>

#define OST_M_PER_PM 1e-12
#define OST_RIGID 1e12 /* resistance per area, in N s/m^3, of a point that does not cut */

/* The points of a tool, stored by component. Elements after the last point are zero. */
typedef struct contact_shell {
    size_t count;
    float at[3][OST_SHELL_MAX], inward[3][OST_SHELL_MAX];
    float outside[3][OST_SHELL_MAX]; /* position one voxel outward from each point; bone is looked up there */
    /* x and y components of the unit vector opposite to the velocity that the tool's rotation gives to the point */
    float against[2][OST_SHELL_MAX];
    float spin[OST_SHELL_MAX];       /* speed in m/s that the tool's rotation gives to the point */
    float area[OST_SHELL_MAX];
    /* resistance in N s/m of a point that advances into bone of the reference density */
    float give[OST_SHELL_MAX];
    bool cutting[OST_SHELL_MAX];     /* true if the point can cut and the tool rotates */
    bool edge[OST_SHELL_MAX];        /* true if the point can cut */
    /* greatest distance from the tool's origin to a point or to a position in `outside` */
    double reach;
} contact_shell;

/* The pose of the tool's frame. */
typedef struct contact_pose {
    double turn[3][3]; /* rotation from the tool's frame to the bone's frame */
    double at[3];
} contact_pose;

/* The points that touch bone, and the density of the bone at each of them. */
typedef struct contact {
    size_t count;
    uint16_t which[OST_SHELL_MAX];
    int16_t density[OST_SHELL_MAX];
    double depth[OST_SHELL_MAX];    /* thickness by which the layer is compressed (law OST_FORCE_INSTANT) */
    /*
     * Scratch arrays. They contain the positions of the points in voxels relative to an integer origin, the voxels of
     * the points, and the densities of these voxels.
     */
    float position[3][OST_SHELL_MAX];
    int32_t voxel[3][OST_SHELL_MAX];
    int16_t found[OST_SHELL_MAX];
} contact;

/* Computes the rotation matrix of the quaternion w, x, y, z. The quaternion may have any length except 0. */
void ost_turn_of(const double q[4], double turn[3][3]);
void ost_into_bone(const contact_pose *pose, const double v[3], double out[3]);
void ost_into_tool(const contact_pose *pose, const double v[3], double out[3]);

/* Converts a shell to a contact_shell. `spacing` is the edge length of a bone voxel in metres. */
void ost_contact_shell_make(const ost_shell *shell, const ost_force_params *params, double spacing, contact_shell *out);
/* Updates the values that depend on params->speed, the speed of the tool. */
void ost_contact_shell_speed(contact_shell *shell, const ost_force_params *params);
/*
 * Finds the points that touch bone. A point touches bone if the position one voxel outward from the point lies in bone.
 */
ost_status ost_contact_touch(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, contact *c,
                             ost_error *err);
/*
 * Finds the points that press. A point presses if the position `layer` metres outward from the point lies in bone.
 * c->depth is the depth of this position in the bone along the inward normal, limited to 2 * layer. c->density is the
 * density at this position.
 */
ost_status ost_contact_press(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, double layer,
                             contact *c, ost_error *err);

#endif
