/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A shell in the bone: where its points are at a pose, and what bone they meet.
 * Lengths in metres in the bone's frame.
 */
#ifndef OST_FORCE_CONTACT_H
#define OST_FORCE_CONTACT_H

#include <osteon/force.h>

#define OST_M_PER_PM 1e-12

typedef struct contact_point {
    double r[3], inward[3]; /* from the tool's origin, turned into the bone's frame */
    double area;
    int density;            /* of what it touches, HU; 0: nothing */
    double depth;           /* of the layer, pressed together (instant) */
    bool cutting;
} contact_point;

typedef struct contact {
    size_t count;
    contact_point points[OST_SHELL_MAX];
    double axis[3];                 /* the tool's z */
    ost_dims voxels[OST_SHELL_MAX]; /* scratch */
    int16_t densities[OST_SHELL_MAX];
    uint16_t which[OST_SHELL_MAX];
} contact;

double ost_dot(const double a[3], const double b[3]);
void ost_cross(const double a[3], const double b[3], double out[3]);

/* The shell turned as pose is. */
void ost_contact_turn(const ost_shell *shell, const ost_pose *pose, contact *out);
/* With the tool's origin at: the density that each point finds a voxel outward. */
ost_status ost_contact_touch(const ost_bone *bone, const double at[3], contact *c, int *touching, ost_error *err);
/*
 * How deep the point that lies layer outward is in bone, along the inward
 * normal, up to twice the layer; and the density where it begins.
 */
ost_status ost_contact_press(const ost_bone *bone, const double at[3], double layer, contact *c, int *touching, ost_error *err);

#endif
