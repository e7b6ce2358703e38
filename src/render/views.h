/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the cameras of named views and of views that the user moves. The names are those that surgeons use.
 *
 *   operator    over the surgeon's shoulder: the face, seen past the tool
 *   en-face     onto the glenoid's face, along its axis
 *   lateral, anterior, posterior, superior   the glenoid from this side
 *   medial, inferior   the entire bone from this side, because the bone hides the glenoid
 *   tool        along the tool, from behind
 *   whole       the entire bone, obliquely
 *
 * A camera that the user moves orbits a point. The position of the camera is given by azimuth, elevation over the
 * horizon (the transverse plane of the body), and distance. The point can be shifted sideways.
 */
#ifndef OST_RENDER_VIEWS_H
#define OST_RENDER_VIEWS_H

#include <osteon/render.h>

/* Focal length of every view, in units of the picture's height: 0.5 / tan(45 degrees / 2). */
#define OST_VIEW_FOCAL 1.2071067811865475

typedef enum ost_view_name {
    OST_VIEW_OPERATOR,
    OST_VIEW_EN_FACE,
    OST_VIEW_LATERAL,
    OST_VIEW_MEDIAL,
    OST_VIEW_ANTERIOR,
    OST_VIEW_POSTERIOR,
    OST_VIEW_SUPERIOR,
    OST_VIEW_INFERIOR,
    OST_VIEW_TOOL,
    OST_VIEW_OVERVIEW,
    OST_VIEW_COUNT
} ost_view_name;

/* Names of the views for an option, in the order of the enumeration. */
#define OST_VIEW_NAMES "operator|en-face|lateral|medial|anterior|posterior|superior|inferior|tool|whole"

/* The objects in view. All positions are in the bone's frame, in millimetres. */
typedef struct ost_view_subject {
    /* middle: middle of the bone's grid; size: longest side of this grid. After ost_view_subject_fit, both refer to the
       bone itself */
    double middle[3], size;
    bool has_face;           /* true if `face` and `inward` are valid */
    /* face: centre of the glenoid; inward: unit vector from there into the bone */
    double face[3], inward[3];
    bool has_landmarks;      /* true if `trigonum` and `inferior` are valid */
    double trigonum[3], inferior[3]; /* trigonum spinae and inferior angle of a scapula */
    bool left;               /* true for a bone from the left side of the body */
} ost_view_subject;

typedef struct ost_orbit {
    double at[3];            /* point that the camera orbits, in mm */
    /* angles in radians; the azimuth is 0 at the front and increases toward the patient's left */
    double azimuth, elevation;
    double distance;         /* mm */
} ost_orbit;

/* Creates a subject. `at` and `axis` are the position and the axis of the glenoid; `axis` is NULL if it is unknown. */
ost_view_subject ost_view_subject_make(const ost_geometry *bone, const ost_pm3 *at, const double *axis, bool left);

/* Computes the bounding box lo <= v < hi of the voxels whose density is at least the threshold. If there are none,
   sets lo and hi to the middle of the grid. */
void ost_active_box(const ost_volume *volume, int32_t threshold, int32_t lo[3], int32_t hi[3]);
/* Sets subject->middle and subject->size from the box of ost_active_box, so that views of the entire bone do not
   depend on the air around it. */
void ost_view_subject_fit(ost_view_subject *subject, const ost_volume *volume, int32_t threshold);

/* Returns the orbit of a view. The view along the tool requires the tool's pose; if `tool` is NULL, the operator's
   view is returned instead. */
ost_orbit ost_view_orbit(ost_view_name view, const ost_view_subject *subject, const ost_pose *tool);

/*
 * ost_orbit_turn rotates the camera around the orbit's point, and ost_orbit_shift shifts this point sideways. dx and dy
 * are in pixels of a picture that is `height` pixels high.
 */
void ost_orbit_turn(ost_orbit *orbit, double dx, double dy, int height);
void ost_orbit_shift(ost_orbit *orbit, double dx, double dy, int height);
/* Zooms by a number of wheel steps, each of which changes the distance by one eighth. */
void ost_orbit_near(ost_orbit *orbit, double steps);

/* Computes the unit vectors to the right, up, and back toward the viewer. */
void ost_orbit_frame(const ost_orbit *orbit, double right[3], double up[3], double back[3]);

/* Computes the orbit's camera, with a vertical angle of view of 45 degrees. */
ost_status ost_orbit_camera(const ost_orbit *orbit, int width, int height, ost_camera *out, ost_error *err);

#endif
