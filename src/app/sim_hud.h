/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is written over a frame: what the hand has and feels, what has been
 * done and how it stands to the plan, how punctual the loop is.
 *
 *   .-------.      S       .-------.     letters grow with the frame, and never
 *   | hand  |              | rates |     fall below what can be read; a panel
 *   '-------'              '-------'     that has no room is left out
 *   R                              L
 *   .----------------.
 *   | what there is  |       10 mm
 *   '----------------' I   |-------|
 */
#ifndef OST_APP_SIM_HUD_H
#define OST_APP_SIM_HUD_H

#include "app/sim.h"
#include "render/legend.h"
#include "render/lettering.h"

typedef struct sim_hud_facts {
    const char *tool;     /* "reamer" */
    const char *device;
    int number, tools;    /* the tool's, from 1 */
    bool running;         /* there was a tick */
    double seconds;       /* of the operation */
    double contact_n, force_n;           /* contact force, on the bone; hand force, on the device */
    double contact_full_n, force_full_n; /* the ends of their scales */
    bool force_given;     /* by a device that has one, be it only shown */
    double removed_mm3;
    bool planned;         /* the next four are known */
    double reached_mm, planned_mm; /* the deepest that this tool removed bone, below the native face; of the plan, 0: not this tool's */
    double back_deg, up_deg; /* of the tool against the plan: how much more to the back and to the head it looks outward */
    bool touching, pedal;
    const char *fault;    /* NULL: none */
    bool plain;           /* nobody has keys */
    bool timings;         /* of the loop and of frames are asked for */
    bool rates;           /* the next are known */
    double ticks_s, frames_s, late_us, takes_us, frame_ms;
    uint64_t missed;
    bool recording, help;
    bool filming;         /* a video is written */
    uint64_t dropped;     /* frames of it that had to be left out */
    const char *message;  /* NULL: none */
    ost_legend legend;    /* of the colours */
    double mm_per_pixel;  /* at what is looked at */
    double right[3], up[3]; /* the picture's, in the bone's frame: for the letters at its edges; zero: none */
} sim_hud_facts;

/* A part of a frame; nothing of it when it has no width. */
typedef struct sim_hud_box {
    int x, y, width, height;
} sim_hud_box;

typedef struct sim_hud_layout {
    sim_hud_box hand, rates, legend, foot, scale, help, edge[4];
} sim_hud_layout;

typedef struct sim_hud sim_hud;

/* For frames of this size on a display of this density (1: 96 to the inch). */
ost_status sim_hud_create(int width, int height, double scale, sim_hud **out, ost_error *err);
void sim_hud_free(sim_hud *hud); /* NULL is allowed */
/* Whether one made for other frames is the same. */
bool sim_hud_suits(const sim_hud *hud, int width, int height, double scale);
/* Where everything goes: within the frame, and no two in the same place. */
sim_hud_layout sim_hud_arrange(const sim_hud *hud, int width, int height, const sim_hud_facts *facts);
/* White within the plan, amber beyond it, red more than a millimetre beyond; planned_mm 0: no plan, white. */
uint32_t sim_hud_depth_colour(double reached_mm, double planned_mm);
void sim_hud_draw(const sim_hud *hud, const ost_sheet *sheet, const sim_hud_facts *facts);
/* A sheet with nothing but a sentence in its middle. */
void sim_hud_say(const sim_hud *hud, const ost_sheet *sheet, const char *sentence);

#endif
