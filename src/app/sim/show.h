/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Renders an operation while the servo loop runs.
 *
 *   operation --ost_live_channel--> viewer --camera--> frames  in a window or, without a window, on a separate thread
 *
 * A sim_show reads the bone once, when it is created. It then applies the changes that the operation makes.
 */
#ifndef OST_APP_SIM_SHOW_H
#define OST_APP_SIM_SHOW_H

#include "app/picture/appearance.h"
#include "app/film/frame_times.h"
#include "app/sim/sim.h"
#include "app/sim/facts.h"
#include "render/viewer.h"
#include "render/views.h"

typedef enum sim_renderer {
    SIM_RENDERER_NONE,
    SIM_RENDERER_AUTO, /* gl if a graphics card executes OpenGL, points otherwise */
    SIM_RENDERER_POINTS,
    SIM_RENDERER_GL,
    SIM_RENDERER_MESH,
    SIM_RENDERER_THESIS
} sim_renderer;
extern const char *const sim_renderer_names[]; /* "none", "auto", "points", "gl", "mesh", "thesis" */

typedef struct sim_show {
    const app_state *app;
    const sim_args *args;
    sim_renderer renderer;    /* the renderer that draws; never SIM_RENDERER_AUTO */
    ost_live_channel *live;
    bool on_device;           /* true if the bone's voxels are on an OpenCL device */
    ost_viewer viewer;
    int width, height;        /* size of the last frame */
    bool on_screen;           /* true if the last frame was drawn directly into the window */
    uint64_t shown;           /* number of such frames */
    ost_backend *mesher;      /* owned; computes the meshes for SIM_RENDERER_MESH; NULL with other renderers */
    ost_view_subject subject;
    ost_orbit orbit;
    sim_scene scene;
    sim_hud *hud;             /* owned; the HUD of frames that are not shown in a window */
    film *film;               /* borrowed; NULL if no film is written */
    appearance look;
    ost_tool_volume ghost_tool; /* volume of the first tool, for drawing this tool as a ghost */
    frame_times drawn, apart; /* histograms for the entire operation: time to draw a frame, and time between frames */
    int64_t updated_ns;       /* start time of the current frame */
    int64_t last_ns;          /* start time of the previous frame; 0 after a pause */
    int64_t end_ns;           /* time at which the operation ended */
    void *thread;             /* the drawing thread; NULL if there is none */
    ost_status status;        /* status of the drawing thread */
    ost_error err;
} sim_show;

/* Creates s->show, or leaves it NULL if the options select no renderer. */
ost_status sim_show_make(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
void sim_show_free(sim_show *show);

/* Starts a frame: applies the changes that the operation made since the previous frame. */
ost_status sim_show_update(sim_show *show, ost_error *err);
/*
 * Draws a frame of the given size. If `sheet` is not NULL, ost_viewer_can_show must
 * be true, and the frame is drawn into the window's framebuffer with the sheet over it. If OpenGL fails, or if `sheet`
 * is NULL, the frame is drawn into show->viewer.frame.
 */
ost_status sim_show_frame(sim_show *show, int width, int height, const ost_gl_sheet *sheet, ost_error *err);
/* Ends a frame, and adds its duration to the histograms. */
void sim_show_done(sim_show *show);

/* Starts the thread that draws frames until sim_show_end is called. */
ost_status sim_show_begin(sim_show *show, ost_error *err);
/* Waits for the drawing thread and writes the requested picture. Must be called after the servo loop has ended. */
ost_status sim_show_end(sim_show *show, ost_error *err);
void sim_show_report(const app_state *app, const sim_show *show);

#endif
