/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon render`.
 *
 *   cmd_render.c   parses the options
 *   draw.c         loads the bone and the tool, draws the picture and writes it
 *   report.c       reports the picture and its renderer
 */
#ifndef OST_APP_RENDER_RENDER_H
#define OST_APP_RENDER_RENDER_H

#include "app/input/load.h"
#include "app/picture/appearance.h"
#include "app/picture/view.h"
#include "render/viewer.h"

typedef struct render_args {
    const char *bone, *before, *tool, *pose_text, *out;
    int style, renderer, width, height;
    view_options view;
    double depth_mm;
    option_decimal depth;
    appearance_options look;
    ost_pose pose;
    ct_options ct;
    tool_options how;
    target_options target;
} render_args;

/* Values of render_args.renderer: the index in the list of --renderer. */
enum { RENDERER_POINTS, RENDERER_AUTO, RENDERER_GL, RENDERER_MESH, RENDERER_THESIS };

/* The objects of which the picture is made, and the picture. render_free frees them. */
typedef struct render_drawing {
    ost_backend *backend;
    ost_bone *bone;
    ost_tool *tool;
    ost_import_result imported;
    ost_live_channel *live;
    ost_viewer viewer;
    ost_view_subject subject;
    ost_volume before;
    ost_tool_volume tool_volume;
    appearance look;
    ost_picture picture;
    double draw_ms;
} render_drawing;

/*
 * Loads the bone and the tool, draws the picture and writes it to --out. The caller zero-initializes *d and calls
 * render_free, even after an error.
 */
ost_status render_draw(const app_state *app, const render_args *args, render_drawing *d, ost_error *err);
void render_free(render_drawing *d);

/* Prints and stores the size, the drawing time and the renderer of the picture. `file` is the digest of the file. */
void render_report(const app_state *app, const render_args *args, const render_drawing *d, const ost_digest *file);

#endif
