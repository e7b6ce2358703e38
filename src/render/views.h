/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where to look from, by names that surgeons use, and by hand.
 *
 *   en-face     onto the glenoid's face, along its axis
 *   lateral     from the patient's side      anterior, posterior, superior   likewise
 *   operator    over the shoulder of who works: the face, seen past the tool
 *   tool        along the tool, from behind
 *   whole       all of the bone
 *
 * A camera by hand goes about a point: by azimuth and elevation over the
 * horizon (the plane across the body), nearer and farther, and the point
 * itself to the side.
 */
#ifndef OST_RENDER_VIEWS_H
#define OST_RENDER_VIEWS_H

#include <osteon/render.h>

typedef enum ost_view_name {
    OST_VIEW_OPERATOR,
    OST_VIEW_EN_FACE,
    OST_VIEW_LATERAL,
    OST_VIEW_ANTERIOR,
    OST_VIEW_POSTERIOR,
    OST_VIEW_SUPERIOR,
    OST_VIEW_TOOL,
    OST_VIEW_WHOLE,
    OST_VIEW_COUNT
} ost_view_name;

extern const char *const ost_view_names[OST_VIEW_COUNT]; /* "operator", "en-face", ... */

/* What there is to see, in the bone's frame and millimetres. */
typedef struct ost_view_subject {
    double middle[3], size;  /* of the bone: its grid's middle and longest side */
    bool has_face;           /* the next three are known */
    double face[3], inward[3]; /* the glenoid: its centre; the direction into the bone, a unit vector */
    bool left;               /* of the body */
} ost_view_subject;

typedef struct ost_orbit {
    double at[3];            /* mm: what it looks at */
    double azimuth, elevation; /* radians; azimuth 0 from the front, growing toward the patient's left */
    double distance;         /* mm */
} ost_orbit;

/* at and axis as a glenoid's are; axis NULL: there is none that is known. */
ost_view_subject ost_view_subject_make(const ost_geometry *bone, const ost_pm3 *at, const double *axis, bool left);

/* tool: its pose, for the view along it; NULL: as the operator. */
ost_orbit ost_view_orbit(ost_view_name view, const ost_view_subject *subject, const ost_pose *tool);

/* By so many pixels of a picture so high. */
void ost_orbit_turn(ost_orbit *orbit, double dx, double dy, int height);
void ost_orbit_shift(ost_orbit *orbit, double dx, double dy, int height);
void ost_orbit_near(ost_orbit *orbit, double steps); /* a step of a wheel is an eighth */

/* Unit vectors to the right, up and out of the picture toward who looks. */
void ost_orbit_frame(const ost_orbit *orbit, double right[3], double up[3], double back[3]);

/* 45 degrees high. */
ost_status ost_orbit_camera(const ost_orbit *orbit, int width, int height, ost_camera *out, ost_error *err);

#endif
