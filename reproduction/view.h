/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a model, and optionally a tool, as a PNG. The picture is drawn by the simulator's renderer on the processor
 * (render/viewer.h), so it consists of the same bytes on every machine.
 */
#ifndef OST_REPRODUCTION_VIEW_H
#define OST_REPRODUCTION_VIEW_H

#include <osteon/phantom.h>
#include <osteon/sim.h>

#include "render/overlay.h"
#include "render/views.h"

enum { VIEW_WIDTH = 1200, VIEW_HEIGHT = 800 };

typedef struct view_scene {
    const ost_volume *bone;      /* cubic voxels */
    /* the uncut bone, to colour the cut surface by its depth below the uncut surface; NULL for the colour of bone */
    const ost_volume *before;
    const ost_tool_volume *tool; /* NULL if no tool is drawn */
    ost_pose pose;
    const ost_glenoid *glenoid;  /* NULL if the glenoid is not known; the picture then shows the complete bone */
    ost_view_name view;
    /* angles in radians that are added to the azimuth and to the elevation of the view */
    double turn, lift;
    /* height of the view in mm, in the plane through its centre; 0 selects the view's default */
    double extent_mm;
    unsigned overlays;           /* the bit 1 << o is set for each ost_overlay o that is drawn */
    ost_style style;
    bool unoriented;             /* true if the letters for the patient's directions are omitted */
    int threads;
} view_scene;

/* Draws the scene with a scale bar and, if the cut surface is coloured, a legend. The caller frees *png. */
ost_status view_draw(const view_scene *scene, uint8_t **png, size_t *size, ost_error *err);

/* Returns the pose of a built-in path at which the tool is deepest along the glenoid's axis. */
ost_status view_deepest(ost_builtin path, const ost_glenoid *glenoid, const ost_tool_geometry *tool, ost_pose *out,
                        ost_error *err);

#endif
