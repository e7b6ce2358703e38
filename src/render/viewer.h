/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a running operation as frames: the bone as it is removed, and the tool at its pose.
 *
 *   ost_live_channel --take--> surface of the bone --.
 *   tool volumes ----> surfaces of tools ----+--camera--> frame
 *   ost_live_channel --state--> the tool's pose -----'
 *
 *   reference (uncut bone) ------> colours of the cut surface
 *   clip plane, ghost, overlays -> drawn in the same frame
 *
 * A viewer must be used by only one thread at a time. If a viewer follows no live state, it draws the surfaces that its
 * user has set.
 */
#ifndef OST_RENDER_VIEWER_H
#define OST_RENDER_VIEWER_H

#include <osteon/live.h>
#include <osteon/tool.h>

#include "render/gl/gl.h"
#include "render/overlay.h"
#include "render/points/clip.h"
#include "render/points/frame.h"
#include "render/points/uncut.h"

enum { OST_VIEWER_TOOLS = 16, OST_GHOST = 120 };
/* interval in ns of operation time; removed bone is highlighted for one to two intervals after its removal */
#define OST_VIEWER_FRESH_NS INT64_C(150000000)

typedef struct ost_viewer {
    ost_live_channel *live;      /* borrowed; live state of the operation that is followed; NULL if none */
    ost_surface bone;
    ost_surface tool[OST_VIEWER_TOOLS];
    ost_tool_geometry tool_grid[OST_VIEWER_TOOLS];
    /* smooth meshes of the tools; empty for a tool that is drawn as voxels */
    ost_smooth_mesh tool_mesh[OST_VIEWER_TOOLS];
    int tools;
    ost_isa isa;
    int threads;
    ost_style style;
    bool antialiased;    /* true to smooth edges with OST_STYLE_SMOOTH; must be set before the first frame */
    ost_paint paint;     /* paint of the bone; defaults to OST_PAINT_BONE */
    ost_frame frame;     /* last frame drawn, in the size of the camera's picture */
    ost_live_state state;
    bool has_state;      /* true if `state` is valid; the tool is then drawn at its pose in `state` */
    uint64_t changed;    /* number of changed chunks taken from `live` so far */
    ost_uncut reference; /* uncut bone; valid if `has_uncut` is true */
    bool has_uncut;
    uint32_t palette[OST_PAINTS];
    ost_surface ghost;   /* surface of the ghost; valid if `has_ghost` is true; drawn if `show_ghost` is also true */
    ost_pose ghost_pose;
    bool has_ghost, show_ghost;
    unsigned overlays;   /* bit mask of the selected overlays (ost_overlay) */
    ost_overlay_scene scene;
    int64_t aged_ns;
    ost_gl *gl;          /* OpenGL renderer; owned; NULL if the CPU draws frames */
    bool gl_current;     /* true if `gl` uses the context of the calling thread (ost_viewer_use_current) */
    const ost_gl_variant *variant;
    /* reason why OpenGL was lost; "" if it was not lost. After a loss, the CPU draws the frames */
    char lost[OST_ERROR_TEXT];
    char no_card[OST_ERROR_TEXT]; /* reason why ost_viewer_use_card did not select OpenGL; "" if it did */
} ost_viewer;

/* Creates a viewer with an empty bone. For `isa` and `threads`, see ost_points_options. */
ost_status ost_viewer_init(ost_viewer *viewer, const ost_geometry *bone, ost_style style, const char *isa, int threads,
                           ost_error *err);
void ost_viewer_free(ost_viewer *viewer); /* accepts a zero-initialized viewer */

/*
 * Selects OpenGL for the following frames. If OpenGL fails later, the CPU draws the frames, and viewer->lost states the
 * reason. Returns OST_ERR_UNAVAILABLE under the same conditions as ost_gl_open.
 */
ost_status ost_viewer_use_gl(ost_viewer *viewer, const ost_gl_variant *variant, ost_error *err);

/*
 * Selects OpenGL with the context that is current on the calling thread, for example the context of a window. On
 * success, the viewer must then be used only on this thread and with this context current. Returns OST_ERR_UNAVAILABLE
 * if the context belongs to a software renderer.
 */
ost_status ost_viewer_use_current(ost_viewer *viewer, ost_error *err);
/*
 * Must be called after the context of ost_viewer_use_current was destroyed or has become unusable. The CPU draws the
 * following frames, and viewer->lost states the reason, which may be "".
 */
void ost_viewer_context_lost(ost_viewer *viewer, const char *reason);

/*
 * Selects OpenGL for the following frames if it runs on a graphics card. Otherwise, the CPU draws the same points, and
 * viewer->no_card states the reason.
 */
void ost_viewer_use_card(ost_viewer *viewer);

/*
 * Selects OpenGL with triangle meshes of the visible faces (ost_gl_mesh). `mesher` is the backend that makes the
 * meshes; it is borrowed, and must not be used elsewhere while a frame is drawn. Tests the backend with an empty chunk.
 * Returns OST_ERR_UNAVAILABLE if the backend cannot make meshes, or under the same conditions as ost_gl_open.
 */
ost_status ost_viewer_use_mesh(ost_viewer *viewer, ost_backend *mesher, ost_error *err);

/* Adds a tool. The tools must be added in the order in which they were added to the world. */
ost_status ost_viewer_add_tool(ost_viewer *viewer, const ost_tool_volume *volume, ost_error *err);
/*
 * Sets the meshes of the most recently added tool, one mesh for each part, in the frame of the tool. With
 * OST_STYLE_SMOOTH, the meshes are drawn instead of the tool's voxels if the number of triangles is 1 to
 * OST_SMOOTH_TRIANGLES_MAX.
 */
ost_status ost_viewer_smooth_tool(ost_viewer *viewer, const ost_mesh *parts, int count, ost_error *err);
/*
 * Sets the uncut bone and takes ownership of the volume, as ost_uncut_init does. Must be called before the surface of
 * the bone is first set or updated.
 */
ost_status ost_viewer_set_uncut(ost_viewer *viewer, ost_volume *before, int32_t threshold,
                                const ost_density_classes *classes, const ost_pm3 *at, const double *axis,
                                ost_error *err);
/* Sets the colouring. All colourings except OST_COLOUR_BONE require the uncut bone. */
void ost_viewer_set_colouring(ost_viewer *viewer, ost_colouring colouring);
/* Sets the clip plane; NULL shows the complete bone. */
void ost_viewer_set_clip(ost_viewer *viewer, const ost_clip *clip);
/* Sets the ghost (a translucent implant) and its pose. */
ost_status ost_viewer_set_ghost(ost_viewer *viewer, const ost_tool_volume *volume, const ost_pose *pose,
                                ost_error *err);
/* Enables or disables highlighting where bone was just removed. */
void ost_viewer_set_contact(ost_viewer *viewer, bool shown);

/* Makes the viewer follow the operation whose live state is published in `live`, which is borrowed. */
void ost_viewer_follow(ost_viewer *viewer, ost_live_channel *live);
/* Applies the changes that viewer->live has published since the last call. */
ost_status ost_viewer_update(ost_viewer *viewer, ost_error *err);
/* Draws a frame into viewer->frame, which is resized to the camera's picture. The camera must have passed
   ost_camera_check. */
ost_status ost_viewer_draw(ost_viewer *viewer, const ost_camera *camera, ost_error *err);
/*
 * Draws the bone and the tool, without overlays and ghost, into a picture that stays in OpenGL (ost_gl_copy,
 * ost_gl_show). viewer->frame does not change. `middle` is the point at which the forward axis passes through the
 * picture, in pixels from the left and top edges; NULL means the middle of the picture. Returns OST_ERR_UNAVAILABLE if
 * OpenGL is not in use or fails, and OST_ERR_RANGE under the same conditions as ost_gl_draw.
 */
ost_status ost_viewer_draw_gl(ost_viewer *viewer, const ost_camera *camera, const double middle[2], ost_error *err);
/*
 * ost_viewer_show draws a frame into framebuffer 0 of the context of ost_viewer_use_current. `sheet`, which has the
 * frame's size, is drawn over the frame. The frame is not read back. If OpenGL fails, viewer->gl is NULL afterwards,
 * and the caller can use ost_viewer_draw. ost_viewer_can_show returns true if OpenGL draws in this context and neither
 * a ghost nor an overlay is shown, because only the CPU can draw these.
 */
bool ost_viewer_can_show(const ost_viewer *viewer);
ost_status ost_viewer_show(ost_viewer *viewer, const ost_camera *camera, const ost_gl_sheet *sheet, ost_error *err);

#endif
