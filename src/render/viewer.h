/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A running operation as frames: the bone as it goes, the tool where it is.
 *
 *   ost_live --take--> surface of the bone --.
 *   tool volumes ----> surfaces of tools ----+--camera--> frame
 *   ost_live --state--> the tool's pose -----'
 *
 *   ground (what was before) ---> colours of what was cut
 *   clip plane, ghost, overlays -> seen with it
 *
 * One thread at a time.  A viewer that follows nothing shows what was set.
 */
#ifndef OST_RENDER_VIEWER_H
#define OST_RENDER_VIEWER_H

#include <osteon/live.h>
#include <osteon/tool.h>

#include "render/gl/gl.h"
#include "render/overlay.h"
#include "render/points/clip.h"
#include "render/points/frame.h"
#include "render/points/ground.h"

enum { OST_VIEWER_TOOLS = 16, OST_GHOST = 120 };
#define OST_VIEWER_FRESH_NS INT64_C(150000000) /* of the operation's time: bone that went is shown for one to two of these */

typedef struct ost_viewer {
    ost_live *live;      /* borrowed; NULL: it follows nothing */
    ost_surface bone;
    ost_surface tool[OST_VIEWER_TOOLS];
    ost_tool_geometry tool_grid[OST_VIEWER_TOOLS];
    int tools;
    ost_isa isa;
    int threads;
    ost_style style;
    ost_frame frame;     /* of the last draw's size */
    ost_live_state state;
    bool has_state;      /* the tool is drawn where state says */
    uint64_t changed;    /* chunks that were taken */
    ost_ground ground;   /* with has_ground */
    bool has_ground;
    uint32_t palette[OST_PAINTS];
    ost_surface ghost;   /* with has_ghost; shown with show_ghost */
    ost_pose ghost_pose;
    bool has_ghost, show_ghost;
    unsigned overlays;   /* bits of ost_overlay */
    ost_overlay_scene scene;
    int64_t aged_ns;
    ost_gl *gl;          /* owned; NULL: the processor draws */
    const ost_gl_variant *variant;
    char lost[OST_ERROR_TEXT]; /* why it is the processor again; "" */
} ost_viewer;

/* isa and threads as ost_points_options has them. */
ost_status ost_viewer_init(ost_viewer *viewer, const ost_geometry *bone, ost_style style, const char *isa, int threads, ost_error *err);
void ost_viewer_free(ost_viewer *viewer); /* also of a zeroed one */

/* Frames are OpenGL's from now on, until it fails: then the processor's again, and lost says why. OST_ERR_UNAVAILABLE as ost_gl_open. */
ost_status ost_viewer_use_gl(ost_viewer *viewer, const ost_gl_variant *variant, ost_error *err);

/* In the order of the world's. */
ost_status ost_viewer_add_tool(ost_viewer *viewer, const ost_tool_volume *volume, ost_error *err);
/* What the bone was before anything was cut: takes the volume. As ost_ground_init. Before the bone is first set or taken. */
ost_status ost_viewer_set_ground(ost_viewer *viewer, ost_volume *before, int32_t threshold, const ost_density_classes *classes,
                                 const ost_pm3 *at, const double *axis, ost_error *err);
/* All but OST_COLOUR_BONE need a ground. */
void ost_viewer_set_colouring(ost_viewer *viewer, ost_colouring colouring);
/* NULL: all is shown. */
void ost_viewer_set_clip(ost_viewer *viewer, const ost_clip *clip);
/* A shape that can be seen through. */
ost_status ost_viewer_set_ghost(ost_viewer *viewer, const ost_tool_volume *volume, const ost_pose *pose, ost_error *err);
/* Where bone goes is shown for a moment. */
void ost_viewer_set_contact(ost_viewer *viewer, bool shown);

/* From now on the bone is what live shows. */
void ost_viewer_follow(ost_viewer *viewer, ost_live *live);
/* What has changed since the last time. */
ost_status ost_viewer_update(ost_viewer *viewer, ost_error *err);
/* Into the frame, whose size is the camera's, which was checked. */
ost_status ost_viewer_draw(ost_viewer *viewer, const ost_camera *camera, ost_error *err);

#endif
