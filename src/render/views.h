/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the camera positions of named views, whose names are those that surgeons use, and of
 * cameras that the user moves.
 *
 *   operator    over the surgeon's shoulder: the face, seen past the tool
 *   en-face     onto the glenoid's face, along its axis
 *   lateral, anterior, posterior, superior   the glenoid from this side
 *   medial, inferior   the entire bone from this side, because the bone hides the glenoid
 *   tool        along the tool, from behind
 *   whole       the entire bone, obliquely
 *
 * A camera that the user moves orbits a point. The position of the camera is given by its azimuth,
 * its elevation over the horizon (the plane across the body), and its distance. The point can be
 * moved sideways.
 */
#ifndef OST_RENDER_VIEWS_H
#define OST_RENDER_VIEWS_H

#include <osteon/render.h>

/* The focal length of every view, in units of the picture's height: 0.5 / tan(45 degrees / 2). */
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

/* The names of the views, as the choices of an option. They are in the order of the enumeration. */
#define OST_VIEW_NAMES "operator|en-face|lateral|medial|anterior|posterior|superior|inferior|tool|whole"

/* The objects in view. All positions are in the bone's frame, in millimetres. */
typedef struct ost_view_subject {
    /*
     * `middle` is the middle and `size` the longest side of the bone's grid. ost_view_subject_fit replaces them by the
     * values for the bone.
     */
    double middle[3], size;
    bool has_face;           /* true if `face` and `inward` are valid */
    /* `face` is the centre of the glenoid, and `inward` the unit vector from there into the bone */
    double face[3], inward[3];
    bool has_landmarks;      /* true if `trigonum` and `inferior` are valid */
    double trigonum[3], inferior[3]; /* trigonum spinae and inferior angle of a scapula */
    bool left;               /* true if the bone is from the left side of the body */
} ost_view_subject;

typedef struct ost_orbit {
    double at[3];            /* point that the camera orbits, in mm */
    /* angles in radians; the azimuth is 0 at the front and increases toward the patient's left */
    double azimuth, elevation;
    double distance;         /* mm */
} ost_orbit;

/*
 * Creates a subject. The parameters `at` and `axis` are the position and the axis of the glenoid; axis is NULL if the
 * glenoid is unknown.
 */
ost_view_subject ost_view_subject_make(const ost_geometry *bone, const ost_pm3 *at, const double *axis, bool left);

/* Computes the box lo <= v < hi of the voxels whose density is at least the threshold. If there are no such voxels,
   sets lo and hi to the middle of the grid. */
void ost_active_box(const ost_volume *volume, int32_t threshold, int32_t lo[3], int32_t hi[3]);
/* Sets subject->middle and subject->size from the box that ost_active_box computes, so that views of the entire bone do
   not depend on the air around the bone. */
void ost_view_subject_fit(ost_view_subject *subject, const ost_volume *volume, int32_t threshold);

/* Returns the orbit of a view. The view along the tool needs the pose of the tool; if `tool` is NULL, the operator's
   view is returned instead. */
ost_orbit ost_view_orbit(ost_view_name view, const ost_view_subject *subject, const ost_pose *tool);

/*
 * ost_orbit_turn turns the orbit, and ost_orbit_shift moves it sideways. The distances dx and dy are in pixels of a
 * picture that is `height` pixels high.
 */
void ost_orbit_turn(ost_orbit *orbit, double dx, double dy, int height);
void ost_orbit_shift(ost_orbit *orbit, double dx, double dy, int height);
/* Zooms by a number of steps of the mouse wheel. Each step changes the distance by one eighth. */
void ost_orbit_near(ost_orbit *orbit, double steps);

/* Computes unit vectors that point right, up, and out of the picture toward the viewer. */
void ost_orbit_frame(const ost_orbit *orbit, double right[3], double up[3], double back[3]);

/* Computes the orbit's camera, with a vertical angle of view of 45 degrees. */
ost_status ost_orbit_camera(const ost_orbit *orbit, int width, int height, ost_camera *out, ost_error *err);

#endif
