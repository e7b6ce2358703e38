/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws the HUD over a frame. The HUD shows the state of the simulated hand and its forces, a comparison of the
 * operation with the plan, and how well the servo loop meets its deadlines.
 *
 *   .-------.      S       .-------.     letters grow with the frame and never
 *   | hand  |              | rates |     become unreadably small; a panel for
 *   '-------'              '-------'     which there is no space is omitted
 *   R                              L
 *   .----------------.
 *   |    messages    |       10 mm
 *   '----------------' I   |-------|
 */
#ifndef OST_APP_SIM_HUD_H
#define OST_APP_SIM_HUD_H

#include "app/sim/sim.h"
#include "render/legend.h"
#include "render/lettering.h"

typedef struct sim_hud_facts {
    const char *tool;     /* name of the tool, for example "reamer" */
    const char *device;
    int number, tools;    /* number of the current tool, counted from 1, and total number of tools */
    bool running;         /* false before the first tick */
    double seconds;       /* time since the operation began */
    double contact_n, force_n;           /* contact force on the bone, and hand force on the device, in newtons */
    double contact_full_n, force_full_n; /* upper ends of the scales for contact force and hand force, in newtons */
    bool force_given;     /* true if a force is computed, even if the device does not render it */
    double removed_mm3;
    bool planned;         /* true if the following four members are valid */
    /* The maximum depth below the native face at which the tool removed bone, and the planned depth of the tool. The
       planned depth is 0 if no depth is planned. */
    double reached_mm, planned_mm;
    /* Deviation of the tool's outward axis from the planned axis, in degrees: toward posterior, and toward superior. */
    double back_deg, up_deg;
    bool touching, pedal;
    const char *fault;    /* name of the device's fault; NULL if there is no fault */
    bool plain;           /* true if the hint about the key F1 is not drawn, because there is no keyboard */
    bool timings;         /* true to show the times of ticks and frames */
    bool rates;           /* true if the following five members are valid */
    double ticks_s, frames_s, late_us, takes_us, frame_ms;
    uint64_t missed;
    bool recording, help;
    bool filming;         /* true while a video is being written */
    uint64_t dropped;     /* number of frames dropped from the video */
    const char *message;  /* message to show; NULL if there is none */
    ost_legend legend;    /* the legend, which explains the colours */
    double mm_per_pixel;  /* size of a pixel in mm at the camera's target */
    /* The directions of the picture in the bone's frame, for the letters at the picture's edges. They are zero if no
     * letters are drawn. */
    double right[3], up[3];
} sim_hud_facts;

/* A rectangle of a frame; empty if its width is 0. */
typedef struct sim_hud_box {
    int x, y, width, height;
} sim_hud_box;

typedef struct sim_hud_layout {
    sim_hud_box device, rates, legend, foot, scale, help, edge[4];
} sim_hud_layout;

typedef struct sim_hud sim_hud;

/* Creates a HUD for frames of the given size on a display with the given scale; scale 1 means 96 dpi. */
ost_status sim_hud_create(int width, int height, double scale, sim_hud **out, ost_error *err);
void sim_hud_free(sim_hud *hud); /* hud may be NULL */
/* Returns true if the HUD is suitable for frames of the given size on a display with the given scale. */
bool sim_hud_suits(const sim_hud *hud, int width, int height, double scale);
/* Computes the positions of all parts of the HUD. The parts lie within the frame and do not overlap. */
sim_hud_layout sim_hud_arrange(const sim_hud *hud, int width, int height, const sim_hud_facts *facts);
/*
 * Returns the colour of a depth: white within the plan, amber beyond the plan, and red more than a millimetre beyond
 * the plan. If planned_mm is 0, there is no plan, and the colour is white.
 */
uint32_t sim_hud_depth_colour(double reached_mm, double planned_mm);
void sim_hud_draw(const sim_hud *hud, const ost_sheet *sheet, const sim_hud_facts *facts);
/* Draws only one sentence, in the middle of a sheet. */
void sim_hud_draw_message(const sim_hud *hud, const ost_sheet *sheet, const char *sentence);

#endif
