/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is seen while the loop runs: a renderer at work beside it.
 *
 *   operation --ost_live--> viewer --camera--> frames      in a window, or in a thread of its own without one
 *
 * It takes the bone as it is when it is made, and follows from there.
 */
#ifndef OST_APP_SIM_SHOW_H
#define OST_APP_SIM_SHOW_H

#include "app/appearance.h"
#include "app/frame_times.h"
#include "app/sim.h"
#include "app/sim_beside.h"
#include "app/sim_facts.h"
#include "render/viewer.h"
#include "render/views.h"

typedef enum sim_renderer { SIM_RENDERER_NONE, SIM_RENDERER_NULL, SIM_RENDERER_POINTS, SIM_RENDERER_GL, SIM_RENDERER_THESIS } sim_renderer;
extern const char *const sim_renderer_names[]; /* "none", "null", "points", "gl", "thesis" */

typedef struct sim_show {
    const app_state *app;
    const sim_args *args;
    ost_live *live;
    ost_viewer viewer;
    ost_view_subject subject;
    ost_orbit orbit;
    sim_scene scene;
    sim_hud *hud;             /* of frames without a window; owned */
    film *film;               /* borrowed; NULL: none */
    appearance look;
    ost_tool_volume ghost_tool; /* the first; what its ghost is made of */
    frame_times drawn, apart; /* a frame's work; from one frame to the next; while the operation went on */
    int64_t look_ns;          /* when this frame began */
    int64_t last_ns;          /* when the last one did; 0: it was not drawn right before */
    int64_t end_ns;           /* when the operation was over */
    sim_beside beside;
    void *thread;             /* NULL: none */
    ost_status status;        /* of the thread */
    ost_error err;
} sim_show;

/* NULL with no renderer. */
ost_status sim_show_make(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
void sim_show_free(sim_show *show);

/* Of the loop's thread: what it is at. False: it is not to go on. */
bool sim_show_stage(void *show, ost_servo_stage stage);
/* What changed since the last time: a frame begins. */
ost_status sim_show_look(sim_show *show, ost_error *err);
/* Drawn in this size; nothing is drawn by the renderer null. */
ost_status sim_show_frame(sim_show *show, int width, int height, ost_error *err);
/* All that belongs to it is done. */
void sim_show_done(sim_show *show);

/* Frames by a thread, until the end. */
ost_status sim_show_begin(sim_show *show, ost_error *err);
/* Waits for the thread; the picture that was asked for. The loop is over. */
ost_status sim_show_end(sim_show *show, ost_error *err);
void sim_show_report(const app_state *app, const sim_show *show);

#endif
