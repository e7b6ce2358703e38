/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the state of an operation to the facts that the HUD shows. The operation may be live, with or without a
 * window, or recorded.
 */
#ifndef OST_APP_SIM_FACTS_H
#define OST_APP_SIM_FACTS_H

#include <osteon/live.h>
#include <osteon/metrics.h>
#include <osteon/tool.h>

#include "app/sim/hud.h"

/* The values in the HUD that remain constant during an operation. */
typedef struct sim_scene {
    option_list tools;                /* names of all tools of the operation */
    ost_metrics_tool shapes[OPTION_LIST_MAX];
    const char *device;
    double voxel_mm3;
    bool planned;
    ost_metrics_plan plan;
    bool force_given, recording;
    double device_full_n, contact_full_n; /* upper ends of the HUD's scales: hand force and contact force, in N */
} sim_scene;

/* Makes a scene. `tools` has one element for each name. `plan` is NULL if there is none. */
ost_status sim_scene_make(sim_scene *scene, const option_list *names, ost_tool *const *tools, const ost_geometry *bone,
                          const ost_metrics_plan *plan, ost_error *err);
/*
 * Sets the scales of the forces. max_n is the device's maximum force. The hand force is the contact force multiplied by
 * `scale`.
 */
void sim_scene_forces(sim_scene *scene, double max_n, double scale);
/*
 * Implements the callback depth_of (operation.h). Returns the depth of the tool's tip below the plan's centre, along
 * the plan's axis, in mm. Returns 0 without a plan. `user` is a sim_scene.
 */
double sim_scene_depth(void *user, int32_t tool, const ost_pose *pose);

/* Computes the facts that follow from the state. The caller sets all other facts, such as rates and messages. */
sim_hud_facts sim_facts_make(const sim_scene *scene, const ost_live_state *state, bool has_state);

#endif
