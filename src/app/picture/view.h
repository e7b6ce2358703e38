/* SPDX-License-Identifier: Apache-2.0 */
/* The options of the view, which `osteon render` and `osteon export` share, and the camera that is computed from
   them. */
#ifndef OST_APP_PICTURE_VIEW_H
#define OST_APP_PICTURE_VIEW_H

#include "app/input/ream_path.h"
#include "render/views.h"

typedef struct view_options {
    int view; /* an ost_view_name */
    bool view_given;
    ost_pm extent; /* height of the visible region at the centre of the view; 0 selects the view's default */
    const char *size;
    bool no_legend;
} view_options;

#define VIEW_OPTION(v, text)                                                                                           \
    {                                                                                                                  \
        .name = "view", .kind = OPTION_CHOICE, .out = &(v).view, .given = &(v).view_given, .value = OST_VIEW_NAMES,    \
        .help = text                                                                                                   \
    }
#define VIEW_EXTENT_OPTION(v)                                                                       \
    {.name = "extent", .kind = OPTION_LENGTH, .out = &(v).extent, .value = "MM",                    \
     .help = "height of the view at its centre (default: 83 at the glenoid, else the entire bone)"}

/*
 * Finds the glenoid and the subject of the view. If the glenoid is not known, has_face is false, and --at, if given,
 * sets the middle of the view. Returns OST_ERR_USAGE if the view is lateral or medial and the side is not known.
 * Returns OST_ERR_INPUT under the same conditions as target_find.
 */
ost_status view_subject(const app_state *app, const view_options *options, const target_options *target,
                        const ost_meta *meta, const ost_geometry *geometry, const char *bone, ost_glenoid *glenoid,
                        ost_view_subject *out, ost_error *err);
/* Fits the subject to the bone's voxels. Does nothing if --at sets the middle of the view (view_subject). */
void view_fit(const target_options *target, const ost_volume *volume, int32_t threshold, ost_view_subject *subject);
/* Returns the camera's orbit for the view. For `tool`, see ost_view_orbit. */
ost_orbit view_orbit(const view_options *options, const ost_view_subject *subject, const ost_pose *tool);

/* Returns true if the file or its format states the directions of the grid's axes. */
bool view_oriented(const ost_meta *meta);

#endif
