/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adds the parts of a picture other than the bone and the tool: the colours of the cut surface, a clip plane, the
 * planned implant as a ghost, and explanatory lines. Options control these parts; in the window of `osteon sim`, keys
 * control them too.
 *
 *   options --.
 *   keys -----+--> appearance --> viewer, and a legend over its frame
 */
#ifndef OST_APP_PICTURE_APPEARANCE_H
#define OST_APP_PICTURE_APPEARANCE_H

#include "app/common/options.h"
#include "render/legend.h"
#include "render/lettering.h"
#include "render/viewer.h"
#include "render/views.h"

typedef enum clip_kind {
    CLIP_NONE,
    CLIP_PLAN,
    CLIP_ACROSS,
    CLIP_AXIAL,
    CLIP_CORONAL,
    CLIP_SAGITTAL,
    CLIP_NAMES,
    CLIP_FREE = CLIP_NAMES
} clip_kind;
typedef enum ghost_kind { GHOST_NONE, GHOST_IMPLANT, GHOST_TOOL } ghost_kind;

typedef struct appearance_options {
    int colour;             /* an ost_colouring */
    bool colour_given;
    int ghost;              /* a ghost_kind */
    const char *clip_text;
    option_decimal shift, turn;
    option_list overlays;
    bool no_legend;
    /* appearance_check sets the following members */
    int clip;               /* a clip_kind */
    double clip_at[3], clip_normal[3]; /* point and normal of the clip plane for CLIP_FREE */
    double shift_mm, turn_deg;
    unsigned overlay_bits;
} appearance_options;

#define APPEARANCE_OPTIONS(a)                                                                                          \
    {.name = "colour",                                                                                                 \
     .kind = OPTION_CHOICE,                                                                                            \
     .out = &(a).colour,                                                                                               \
     .given = &(a).colour_given,                                                                                       \
     .value = "bone|class|depth|density",                                                                              \
     .help = "colour of the cut surface: as bone, by density class, by depth below the uncut surface, or by "          \
             "density (default: bone; of render --before: depth)"},                                                    \
        {.name = "clip",                                                                                               \
         .kind = OPTION_TEXT,                                                                                          \
         .out = &(a).clip_text,                                                                                        \
         .value = "plan|across|axial|coronal|sagittal|X,Y,Z,NX,NY,NZ",                                                 \
         .help = "cut the bone open along a plane and show the CT's densities on it: through the glenoid's centre "    \
                 "along its axis, upright (plan) or across; axial, coronal or sagittal; or through a point, where "    \
                 "N points to the side that is hidden"},                                                               \
        {.name = "clip-shift",                                                                                         \
         .kind = OPTION_DECIMAL,                                                                                       \
         .out = &(a).shift,                                                                                            \
         .value = "MM",                                                                                                \
         .help = "distance by which the plane is moved away from the camera"},                                         \
        {.name = "clip-turn",                                                                                          \
         .kind = OPTION_DECIMAL,                                                                                       \
         .out = &(a).turn,                                                                                             \
         .value = "DEG",                                                                                               \
         .help = "angle by which plan or across is rotated about the glenoid's axis"},                                 \
        {.name = "ghost",                                                                                              \
         .kind = OPTION_CHOICE,                                                                                        \
         .out = &(a).ghost,                                                                                            \
         .value = "none|implant|tool",                                                                                 \
         .help = "draw an implant, or the tool, translucent at the planned depth"},                                    \
        {.name = "overlay",                                                                                            \
         .kind = OPTION_LIST,                                                                                          \
         .out = &(a).overlays,                                                                                         \
         .value = "chunks|boxes|hits|tool-voxels|bone-voxels|axis|landmarks",                                          \
         .help = "draw lines: chunks, bounding boxes, the chunks hit, solid voxels of the tool, surface voxels of "    \
                 "the bone, the glenoid's axis, or (osteon render) the landmarks of a scapula; may repeat"},           \
    {                                                                                                                  \
        .name = "no-legend", .kind = OPTION_FLAG, .out = &(a).no_legend,                                               \
        .help = "draw no legend, scale bar or directions"                                                              \
    }

ost_status appearance_check(const app_state *app, appearance_options *options, ost_error *err);

typedef struct appearance {
    ost_viewer *viewer;              /* borrowed, like the subject */
    const ost_view_subject *subject;
    double depth_mm;                 /* planned depth of reaming */
    ost_colouring colouring;
    int clip, overlay_step;
    double clip_at[3], clip_normal[3], shift_mm, turn_deg;
    bool flipped;
    int ghost;
    const ost_tool_volume *tool;     /* borrowed; drawn if `ghost` is GHOST_TOOL; NULL if there is no tool */
    ost_lettering *lettering;        /* owned; lettering of the legend */
    double unit;
} appearance;

/*
 * Initializes *a and applies the options to the viewer. An uncut surface must be set in the viewer before this call.
 * eye_mm is the position of the camera; the part of the bone between the camera and a clip plane is hidden.
 */
ost_status appearance_begin(appearance *a, ost_viewer *viewer, const ost_view_subject *subject, double depth_mm,
                            const ost_tool_volume *tool, const appearance_options *options, const double eye_mm[3],
                            ost_error *err);
void appearance_free(appearance *a); /* *a may be zero-initialized */

ost_legend appearance_legend_of(const appearance *a);
/*
 * Draws the legend over the viewer's frame. If orbit is not NULL, also draws a scale bar and, if `oriented` is set,
 * the patient's directions.
 */
ost_status appearance_marks(appearance *a, const ost_orbit *orbit, bool oriented, ost_error *err);

/*
 * Handles a key: C changes the colours, X the clip plane, Shift X the side of the plane, G the ghost, O the overlays,
 * and K the highlighting of the voxels that were just removed. Page Up and Page Down move the plane or, with Shift,
 * turn the plane. Returns true if the key is one of these; `text` (160 bytes) then describes the change.
 */
bool appearance_key(appearance *a, int key, bool shift, const double eye_mm[3], char *text);
/* Moves the clip plane by a number of steps of the mouse wheel. Returns false if there is no clip plane. */
bool appearance_wheel(appearance *a, double steps, bool fine);

#endif
