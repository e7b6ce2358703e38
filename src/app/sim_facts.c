/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim_facts.h"

#include <math.h>
#include <string.h>

#include "app/sim_hand.h"

static const double DEG = 57.29577951308232, DRILL_MM = 16;

/* The grid begins one to two voxels below the lowest point (Alg. 2.1). */
static double tip_of(const ost_tool *tool)
{
    const ost_tool_geometry *g = ost_tool_geometry_get(tool);
    return -1e-9 * (double)(g->corner.z + 3 * g->voxel / 2);
}

void sim_scene_make(sim_scene *scene, const option_list *names, ost_tool *const *tools, const ost_geometry *bone, const ost_metrics_plan *plan)
{
    const double mm = 1e-9 * (double)bone->spacing.x;
    *scene = (sim_scene){.tools = *names, .voxel_mm3 = mm * mm * mm, .planned = plan != NULL};
    for (int i = 0; i < names->count; i++) {
        const ost_tool_geometry *g = ost_tool_geometry_get(tools[i]);
        scene->tip_mm[i] = tip_of(tools[i]);
        scene->drill[i] = 1e-9 * (double)(g->dims.x * g->voxel) < DRILL_MM;
    }
    if (!plan)
        return;
    scene->plan = *plan;
    double length = 0, *axis = scene->plan.axis;
    for (int a = 0; a < 3; a++)
        length += axis[a] * axis[a];
    for (int a = 0; a < 3; a++)
        axis[a] /= length > 0 ? sqrt(length) : 1;
}

/* Degrees outward of an inward direction, toward the back and toward the head, as the debrief has them. */
static void angles(const double inward[3], bool left, double out[2])
{
    const double lateral = left ? -inward[0] : inward[0];
    out[0] = atan2(-inward[1], lateral) * DEG;
    out[1] = atan2(-inward[2], lateral) * DEG;
}

static void stand_to_plan(const sim_scene *scene, const ost_live_state *state, sim_hud_facts *f)
{
    const ost_metrics_plan *plan = &scene->plan;
    const double at[3] = {1e-9 * (double)plan->at.x, 1e-9 * (double)plan->at.y, 1e-9 * (double)plan->at.z};
    const sim_hand tool = sim_hand_at(&state->pose, state->tool);
    double axis[3], got[2], planned[2];
    sim_hand_axis(&tool, axis);
    for (int a = 0; a < 3; a++)
        f->depth_mm += (tool.at[a] + scene->tip_mm[f->number - 1] * axis[a] - at[a]) * plan->axis[a];
    angles(axis, plan->left, got);
    angles(plan->axis, plan->left, planned);
    f->back_deg = got[0] - planned[0];
    f->up_deg = got[1] - planned[1];
    f->planned_mm = scene->drill[f->number - 1] ? 0 : plan->depth_mm;
    f->planned = true;
}

static const char *short_name(const char *name)
{
    const char *slash = strrchr(name, '/');
    name = slash ? slash + 1 : name;
    return strncmp(name, "builtin:", 8) == 0 ? name + 8 : name;
}

sim_hud_facts sim_facts_make(const sim_scene *scene, const ost_live_state *state, bool has_state)
{
    const bool running = has_state && state->ticks > 0;
    const int tool = running && state->tool >= 0 && state->tool < scene->tools.count ? state->tool : 0;
    const double *n = state->force_n;
    sim_hud_facts f = {
        .tool = scene->tools.count ? short_name(scene->tools.value[tool]) : "",
        .device = scene->device,
        .number = tool + 1,
        .tools = scene->tools.count,
        .running = running,
        .force_given = scene->force_given,
        .recording = scene->recording,
    };
    if (!running)
        return f;
    f.force_n = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    f.removed_mm3 = (double)state->removed_voxels * scene->voxel_mm3;
    f.touching = state->touching > 0;
    f.fault = state->fault ? ost_fault_text((ost_fault)state->fault) : NULL;
    f.missed = state->missed;
    f.seconds = (double)state->t_ns * 1e-9;
    if (scene->planned)
        stand_to_plan(scene, state, &f);
    return f;
}
