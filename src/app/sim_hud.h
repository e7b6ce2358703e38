/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is written over a frame: what the hand has and feels, what has been
 * done and how it stands to the plan, how punctual the loop is.
 */
#ifndef OST_APP_SIM_HUD_H
#define OST_APP_SIM_HUD_H

#include "app/sim.h"
#include "render/lettering.h"

typedef struct sim_hud_facts {
    const char *tool;     /* "reamer" */
    const char *device;
    int number, tools;    /* the tool's, from 1 */
    bool running;         /* there was a tick */
    double force_n;
    bool force_given;     /* a device that has one, be it only shown */
    double removed_mm3;
    bool planned;         /* the next three are known */
    double depth_mm, back_deg, up_deg; /* of the tool against the plan: how much more to the back and to the head it looks outward */
    bool touching, pedal;
    const char *fault;    /* NULL: none */
    double ticks_s, frames_s, late_us, takes_us;
    uint64_t missed;
    bool recording, help;
    const char *message;  /* NULL: none */
    double mm_per_pixel;  /* at what is looked at */
} sim_hud_facts;

typedef struct sim_hud sim_hud;

ost_status sim_hud_create(double scale, sim_hud **out, ost_error *err);
void sim_hud_free(sim_hud *hud); /* NULL is allowed */
void sim_hud_draw(const sim_hud *hud, const ost_sheet *sheet, const sim_hud_facts *facts);
/* A sheet with nothing but a sentence in its middle. */
void sim_hud_say(const sim_hud *hud, const ost_sheet *sheet, const char *sentence);

#endif
