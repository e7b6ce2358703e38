/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a running operation as frames: the bone as it is removed, and the tool at its pose.
 *
 *   ost_live_channel --take--> surface of the bone --.
 *   tool volumes ----> surfaces of tools ----+--camera--> frame
 *   ost_live_channel --state--> the tool's pose -----'
 *
 *   reference (uncut bone) ------> colours of the cut surface
 *   clip plane, ghost, overlays -> drawn with it
 *
 * A viewer must be used by only one thread at a time. If the viewer follows no live state, it shows
 * the surfaces that were set.
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
#define OST_VIEWER_FRESH_NS                                                                                            \
    INT64_C(150000000) /* interval in ns of operation time; removed bone is highlighted for one to two intervals */

typedef struct ost_viewer {
    ost_live_channel *live;      /* borrowed; NULL if the viewer follows no operation */
    ost_surface bone;
    ost_surface tool[OST_VIEWER_TOOLS];
    ost_tool_geometry tool_grid[OST_VIEWER_TOOLS];
    ost_smooth_mesh tool_mesh[OST_VIEWER_TOOLS]; /* empty for a tool that is drawn as voxels */
    int tools;
    ost_isa isa;
    int threads;
    ost_style style;
    bool antialiased;    /* if true, edges are smoothed with OST_STYLE_SMOOTH; must be set before the first frame */
    ost_paint paint;     /* paint of the bone; OST_PAINT_BONE after ost_viewer_init */
    ost_frame frame;     /* the last frame that was drawn, with the size of the camera's picture */
    ost_live_state state;
    bool has_state;      /* set if `state` is valid; the tool is then drawn at the pose in `state` */
    uint64_t changed;    /* number of changed chunks taken from `live` so far */
    ost_uncut reference; /* valid if `has_uncut` is set */
    bool has_uncut;
    uint32_t palette[OST_PAINTS];
    ost_surface ghost;   /* valid if `has_ghost` is set; drawn if `show_ghost` is set */
    ost_pose ghost_pose;
    bool has_ghost, show_ghost;
    unsigned overlays;   /* bit mask of the selected overlays (ost_overlay) */
    ost_overlay_scene scene;
    int64_t aged_ns;
    ost_gl *gl;          /* owned; NULL if the processor draws frames */
    bool gl_current;     /* set if `gl` uses the context that was current (ost_viewer_use_current) */
    const ost_gl_variant *variant;
    /* the reason why frames are drawn by the processor instead of OpenGL; "" if there is no such reason */
    char lost[OST_ERROR_TEXT];
    char no_card[OST_ERROR_TEXT]; /* the reason why ost_viewer_use_card did not select OpenGL; "" if there is none */
} ost_viewer;

/* Creates a viewer with an empty bone. ost_points_options describes `isa` and `threads`. */
ost_status ost_viewer_init(ost_viewer *viewer, const ost_geometry *bone, ost_style style, const char *isa, int threads,
                           ost_error *err);
void ost_viewer_free(ost_viewer *viewer); /* accepts a zero-initialized viewer */

/*
 * Selects OpenGL for the following frames. If OpenGL fails later, the processor draws the frames again, and
 * viewer->lost contains the reason. Returns OST_ERR_UNAVAILABLE under the conditions of ost_gl_open.
 */
ost_status ost_viewer_use_gl(ost_viewer *viewer, const ost_gl_variant *variant, ost_error *err);

/*
 * Opens OpenGL in the context that is current on the calling thread, for example that of a window. If the call
 * succeeds, the functions below use this OpenGL, and the viewer must be used only on this thread, with this context
 * current.
 * Returns OST_ERR_UNAVAILABLE if no graphics card executes the OpenGL of this context.
 */
ost_status ost_viewer_use_current(ost_viewer *viewer, ost_error *err);
/*
 * Must be called after the context of ost_viewer_use_current was destroyed, or can no longer be used. The processor
 * draws the following frames, and viewer->lost contains the reason, which may be "".
 */
void ost_viewer_context_lost(ost_viewer *viewer, const char *reason);

/*
 * Selects OpenGL for the following frames if a graphics card executes it. Otherwise, the processor draws the same
 * points, and viewer->no_card contains the reason.
 */
void ost_viewer_use_card(ost_viewer *viewer);

/*
 * Selects OpenGL with triangle meshes of the visible faces (ost_gl_mesh). `mesher` is the backend that makes the
 * meshes. It is borrowed, and must not be used elsewhere while a frame is drawn. The function meshes an empty chunk to
 * test the backend. Returns OST_ERR_UNAVAILABLE if the backend cannot make meshes, and under the conditions of
 * ost_gl_open.
 */
ost_status ost_viewer_use_mesh(ost_viewer *viewer, ost_backend *mesher, ost_error *err);

/* Adds a tool. Tools must be added in the order of the world's tools. */
ost_status ost_viewer_add_tool(ost_viewer *viewer, const ost_tool_volume *volume, ost_error *err);
/*
 * Sets the meshes of the parts of the tool that was added last. With OST_STYLE_SMOOTH, they are drawn instead of the
 * tool's voxels. The meshes are in the frame of the tool. If they have no triangle, or more than
 * OST_SMOOTH_TRIANGLES_MAX, the tool is drawn as voxels.
 */
ost_status ost_viewer_smooth_tool(ost_viewer *viewer, const ost_mesh *parts, int count, ost_error *err);
/*
 * Sets the uncut bone. Takes ownership of the volume, as ost_uncut_init does. Must be called before the surface of the
 * bone is first set or updated.
 */
ost_status ost_viewer_set_uncut(ost_viewer *viewer, ost_volume *before, int32_t threshold,
                                const ost_density_classes *classes, const ost_pm3 *at, const double *axis,
                                ost_error *err);
/* Sets the colouring. All colourings except OST_COLOUR_BONE need the uncut bone. */
void ost_viewer_set_colouring(ost_viewer *viewer, ost_colouring colouring);
/* Sets the clip plane. If `clip` is NULL, the complete bone is shown. */
void ost_viewer_set_clip(ost_viewer *viewer, const ost_clip *clip);
/* Sets the ghost, a translucent shape, and its pose. */
ost_status ost_viewer_set_ghost(ost_viewer *viewer, const ost_tool_volume *volume, const ost_pose *pose,
                                ost_error *err);
/* Enables or disables the highlighting of places where bone was just removed. */
void ost_viewer_set_contact(ost_viewer *viewer, bool shown);

/* Makes the viewer show the bone of the operation whose live state is published in `live`. The channel is borrowed. */
void ost_viewer_follow(ost_viewer *viewer, ost_live_channel *live);
/* Applies the changes that viewer->live has published since the last call. */
ost_status ost_viewer_update(ost_viewer *viewer, ost_error *err);
/* Draws a frame into viewer->frame, and resizes this frame to the camera's picture. The camera must have passed
   ost_camera_check. */
ost_status ost_viewer_draw(ost_viewer *viewer, const ost_camera *camera, ost_error *err);
/*
 * Draws the bone and the tool into a picture that stays in OpenGL (ost_gl_copy, ost_gl_show). viewer->frame does not
 * change. Overlays and the ghost are not drawn. `middle` is the point of the picture on the camera's axis, in pixels
 * from the left and top edges; NULL means the middle of the picture. Returns OST_ERR_UNAVAILABLE if OpenGL does not
 * draw, and OST_ERR_RANGE under the conditions of ost_gl_draw.
 */
ost_status ost_viewer_draw_gl(ost_viewer *viewer, const ost_camera *camera, const double middle[2], ost_error *err);
/*
 * Draws like ost_viewer_draw, but shows the frame in framebuffer 0 of the context of ost_viewer_use_current, under a
 * sheet of the frame's size. The frame is not read back. If OpenGL fails, viewer->gl is NULL afterwards, and
 * ost_viewer_draw can draw the frame. ost_viewer_can_show returns true if the frame can be shown in this way: OpenGL
 * draws in this context, and neither a ghost nor an overlay is shown, because the processor draws these two.
 */
bool ost_viewer_can_show(const ost_viewer *viewer);
ost_status ost_viewer_show(ost_viewer *viewer, const ost_camera *camera, const ost_gl_sheet *sheet, ost_error *err);

#endif
