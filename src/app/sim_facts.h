/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From what an operation shows to what is written over a frame: of a live one
 * in a window, of one that is drawn without, of a recorded one.
 */
#ifndef OST_APP_SIM_FACTS_H
#define OST_APP_SIM_FACTS_H

#include <osteon/live.h>
#include <osteon/metrics.h>
#include <osteon/tool.h>

#include "app/sim_hud.h"

/* What does not change while it goes on. */
typedef struct sim_scene {
    option_list tools;                /* their names */
    double tip_mm[OPTION_LIST_MAX];   /* from their origin to their lowest point */
    bool drill[OPTION_LIST_MAX];      /* narrow: the plan's depth is a reamer's */
    const char *device;
    double voxel_mm3;
    bool planned;
    ost_metrics_plan plan;
    bool force_given, recording;
} sim_scene;

/* tools: as many as there are names, plan NULL: none is known. */
void sim_scene_make(sim_scene *scene, const option_list *names, ost_tool *const *tools, const ost_geometry *bone, const ost_metrics_plan *plan);

/* What the state says; rates, messages and the rest are the caller's. */
sim_hud_facts sim_facts_make(const sim_scene *scene, const ost_live_state *state, bool has_state);

#endif
