/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/facts.h"

#include <math.h>
#include <string.h>

static const double DEG = 57.29577951308232;

ost_status sim_scene_make(sim_scene *scene, const option_list *names, ost_tool *const *tools, const ost_geometry *bone,
                          const ost_metrics_plan *plan, ost_error *err)
{
    const double mm = 1e-9 * (double)bone->spacing.x;
    *scene = (sim_scene){.tools = *names, .voxel_mm3 = mm * mm * mm, .planned = plan != NULL};
    const ost_force_params force = ost_force_defaults();
    sim_scene_forces(scene, ost_safety_defaults().max_force_n, force.scale);
    for (int i = 0; i < names->count; i++) {
        ost_status status = ost_metrics_tool_make(tools[i], &scene->shapes[i], err);
        if (status != OST_OK)
            return status;
    }
    if (!plan)
        return OST_OK;
    scene->plan = *plan;
    double length = 0, *axis = scene->plan.axis;
    for (int a = 0; a < 3; a++)
        length += axis[a] * axis[a];
    for (int a = 0; a < 3; a++)
        axis[a] /= length > 0 ? sqrt(length) : 1;
    return OST_OK;
}

void sim_scene_forces(sim_scene *scene, double max_n, double scale)
{
    scene->device_full_n = max_n;
    scene->contact_full_n = max_n / scale;
}

double sim_scene_depth(void *user, int32_t tool, const ost_pose *pose)
{
    const sim_scene *scene = user;
    double tip[3], axis[3], depth = 0;
    if (!scene->planned || tool < 0 || tool >= scene->tools.count)
        return 0;
    ost_metrics_tip(&scene->shapes[tool], pose, tip, axis);
    const ost_pm3 *at = &scene->plan.at;
    const double centre[3] = {ost_pm_to_mm(at->x), ost_pm_to_mm(at->y), ost_pm_to_mm(at->z)};
    for (int a = 0; a < 3; a++)
        depth += (tip[a] - centre[a]) * scene->plan.axis[a];
    return depth;
}

/*
 * Computes the angles of the outward direction, which is opposite to `inward`. The angles are in degrees, as in the
 * debrief: out[0] toward posterior, out[1] toward superior.
 */
static void angles(const double inward[3], bool left, double out[2])
{
    const double lateral = left ? -inward[0] : inward[0];
    out[0] = atan2(-inward[1], lateral) * DEG;
    out[1] = atan2(-inward[2], lateral) * DEG;
}

static void compare_with_plan(const sim_scene *scene, const ost_live_state *state, sim_hud_facts *f)
{
    const ost_metrics_plan *plan = &scene->plan;
    const ost_metrics_tool *shape = &scene->shapes[f->number - 1];
    double tip[3], axis[3], got[2], planned[2];
    ost_metrics_tip(shape, &state->pose, tip, axis);
    f->reached_mm = state->reached_mm[f->number - 1];
    angles(axis, plan->left, got);
    angles(plan->axis, plan->left, planned);
    f->back_deg = got[0] - planned[0];
    f->up_deg = got[1] - planned[1];
    f->planned_mm = shape->kind == OST_METRICS_REAMER ? plan->depth_mm : 0;
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
    f.contact_n = state->contact_n;
    f.force_full_n = scene->device_full_n;
    f.contact_full_n = scene->contact_full_n;
    f.removed_mm3 = (double)state->removed_voxels * scene->voxel_mm3;
    f.touching = state->touching > 0 || state->contact_n >= 0.05;
    f.fault = state->fault ? ost_fault_text((ost_fault)state->fault) : NULL;
    f.missed = state->missed;
    f.seconds = (double)state->t_ns * 1e-9;
    if (scene->planned)
        compare_with_plan(scene, state, &f);
    return f;
}
