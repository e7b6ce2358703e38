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
#include "app/tool_shape.h"

/* What does not change while it goes on. */
typedef struct sim_scene {
    option_list tools;                /* their names */
    tool_shape shapes[OPTION_LIST_MAX];
    const char *device;
    double voxel_mm3;
    bool planned;
    ost_metrics_plan plan;
    bool force_given, recording;
    double hand_full_n, contact_full_n; /* the ends of the scales of hand force and contact force */
} sim_scene;

/* tools: as many as there are names, plan NULL: none is known. */
ost_status sim_scene_make(sim_scene *scene, const option_list *names, ost_tool *const *tools, const ost_geometry *bone, const ost_metrics_plan *plan,
                          ost_error *err);
/* The scales of the forces for a device that gives max_n at most, which is scale times the contact force. */
void sim_scene_forces(sim_scene *scene, double max_n, double scale);
/* depth_of of an operation (operation.h): the tip below the plan's centre, along its axis; user is a sim_scene. 0 without a plan. */
double sim_scene_depth(void *user, int32_t tool, const ost_pose *pose);

/* What the state says; rates, messages and the rest are the caller's. */
sim_hud_facts sim_facts_make(const sim_scene *scene, const ost_live_state *state, bool has_state);

#endif
