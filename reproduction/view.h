/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a model, and a tool at a pose, as a PNG: the simulator's renderer on the processor (render/viewer.h), so that
 * a picture consists of the same bytes on every machine.
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
    const ost_volume *before;    /* the uncut bone: the cut surface is coloured by depth; NULL: bone colour */
    const ost_tool_volume *tool; /* NULL: no tool */
    ost_pose pose;
    const ost_glenoid *glenoid;  /* NULL if it is not known; the view is then that of the complete bone */
    ost_view_name view;
    double turn, lift;           /* radians by which the camera is turned further about the vertical, and lifted */
    double extent_mm;            /* height of the picture at the point in view; 0: as the view determines */
    unsigned overlays;           /* bits of ost_overlay */
    ost_style style;
    bool unoriented;             /* no letters for the patient's directions */
    int threads;
} view_scene;

/* Draws the scene, with a scale bar and, if the cut is coloured, a legend. The caller frees *png. */
ost_status view_draw(const view_scene *scene, uint8_t **png, size_t *size, ost_error *err);

/* Returns the pose at which a tool on a built-in path has advanced the farthest. */
ost_status view_deepest(ost_builtin path, const ost_glenoid *glenoid, const ost_tool_geometry *tool, ost_pose *out,
                        ost_error *err);

#endif
