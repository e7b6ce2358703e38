/* SPDX-License-Identifier: Apache-2.0 */
/* Loads and opens everything that the first tick needs. Quick steps come first, so that their errors are reported
   early. */
#include "app/sim/sim.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/backend_choice.h"
#include "app/sim/handle.h"
#include "app/sim/headset.h"
#include "app/common/print.h"
#include "app/session/record.h"
#include "app/sim/window.h"

void simulation_free(simulation *s)
{
    free(s->loop);
    ost_operation_free(s->operation);
    ost_force_free(s->force);
    film_close(s->film, 0, NULL, NULL);
    sim_show_free(s->show);
    ost_volume_free(&s->uncut);
    ost_haptic_close(s->device);
    sim_window_close(s->window);
    sim_headset_close(s->headset);
    ost_recorder_close(s->recorder, NULL, NULL);
    ost_session_close(s->resumed);
    ost_world_free(s->world);
    ost_path_free(&s->path);
    debrief_free(&s->debrief);
    for (int i = 0; i < OPTION_LIST_MAX; i++)
        ost_tool_free(s->tools[i]);
    ost_bone_free(s->bone);
    ost_backend_close(s->backend);
}

/* Determines the plan and the target of built-in paths, or takes both from the resumed session. */
static ost_status take_plan(const app_state *app, const sim_args *args, simulation *s, target_options *target,
                            ost_error *err)
{
    const ost_session_header *header = s->resumed ? ost_session_header_of(s->resumed) : NULL;
    ost_status status = glenoid_plan_find(app, &args->plan, args->resume, header, &s->imported.meta, args->bone,
                                          args->debrief != NULL, &s->plan, &s->planned, err);
    *target = args->plan.target;
    if (status == OST_OK && s->resumed && s->planned) {
        *target = (target_options){.at = s->plan.at,
                                   .at_given = true,
                                   .axis_given = true,
                                   .side = s->plan.left ? 0 : 1,
                                   .side_given = true,
                                   .press_ticks = args->plan.target.press_ticks};
        memcpy(target->axis, s->plan.axis, sizeof target->axis);
    }
    return status == OST_OK && args->debrief
               ? debrief_begin(s->bone, &s->plan, s->tools, args->tools.count, &s->debrief, err)
               : status;
}

/* Moves a pose back along the tool's axis, by at least CLEAR_MM, until none of the tools touches bone. */
static ost_pose back_from_the_bone(const sim_args *args, const simulation *s, const ost_pose *from)
{
    enum { CLEAR_MM = 10, STEP_MM = 2, FARTHEST_MM = 600 };
    for (int mm = CLEAR_MM; mm < FARTHEST_MM; mm += STEP_MM) {
        sim_handle handle = sim_handle_at(from, 0);
        ost_haptic_state state;
        sim_handle_push(&handle, -mm);
        if (!sim_handle_state(&handle, &state))
            break;
        bool clear = true;
        for (int i = 0; i < args->tools.count && clear; i++) {
            int64_t voxels = 0;
            clear = ost_bone_overlap(s->bone, s->tools[i], &state.pose, &voxels, NULL) != OST_OK || voxels == 0;
        }
        if (clear)
            return state.pose;
    }
    return *from;
}

/* Returns a pose 20 mm above the middle of the bone's top, with the tool pointing down. */
static ost_pose over_the_bone(const ost_bone *bone)
{
    ost_pose pose = ost_pose_identity();
    ost_bone_info info;
    if (ost_bone_info_get(bone, &info, NULL) != OST_OK)
        return pose;
    const ost_geometry *g = &info.geometry;
    pose.t = (ost_pm3){g->origin.x + g->dims.x * g->spacing.x / 2, g->origin.y + g->dims.y * g->spacing.y / 2,
                       g->origin.z + g->dims.z * g->spacing.z + 20 * OST_PM_PER_MM};
    return pose;
}

ost_status sim_load(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    ost_status status = backend_choose(app, &s->backend, err);
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = load_tool(app, s->backend, args->tools.value[i], NULL, &args->how, &s->tools[i], NULL, err);
    if (status == OST_OK)
        status = load_bone(app, s->backend, args->bone, &args->ct, false, &s->bone, &s->imported, err);
    const ost_tool_geometry *grids[OPTION_LIST_MAX] = {NULL};
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        grids[i] = ost_tool_geometry_get(s->tools[i]);
    target_options target;
    if (status == OST_OK)
        status = take_plan(app, args, s, &target, err);
    if (status == OST_OK && !sim_device_is(args, "replay"))
        status = ream_path_make(app, &args->paths, &target, &s->imported.meta, args->bone, grids, args->tools.count,
                                &args->gaps, &s->path, &s->gaps, err);
    if (status == OST_ERR_USAGE && !sim_follows_path(args) && !args->paths_given) {
        /* If the bone has no glenoid, there is no path. A device that follows no path needs only an initial pose. */
        status = OST_OK;
        *err = (ost_error){0};
    }
    const ost_world_options options = {
        .sweep_off = args->sweep_off, .removal_period_ns = args->period_ns, .classes = args->classes};
    if (status == OST_OK)
        status = ost_world_create(s->bone, &options, &s->world, err);
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = ost_world_add_tool(s->world, args->tools.value[i], s->tools[i], NULL, err);
    if (status != OST_OK)
        return status;
    const ost_pose first = s->path.count ? s->path.ticks[0].pose : over_the_bone(s->bone);
    const ost_pose start = s->home = sim_follows_path(args) || args->paths_given ? first
                                                                                 : back_from_the_bone(args, s, &first);
    if (s->window && sim_device_is(args, "mouse") && (status = sim_window_mouse_create(s, &start, err)) != OST_OK)
        return status;
    ost_session *session;
    const ost_haptic_setup setup = {
        .path = &s->path,
        .session = args->session,
        .mouse = sim_window_mouse(s),
        .hand = sim_headset_hand(s),
        .start = start,
        .gaps = args->gaps,
    };
    /* The device opens the session itself. This call only prints the warning about missing ticks. */
    if (sim_device_is(args, "replay") && (status = load_session(app, args->session, &session, err)) == OST_OK)
        ost_session_close(session);
    return status == OST_OK ? ost_haptic_open(args->device, &setup, &s->device, err) : status;
}

ost_status sim_check_start(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    start_setup site = {.bone_name = args->bone,
                        .bone = s->bone,
                        .plan = s->planned ? &s->plan : NULL,
                        .names = &args->tools,
                        .tools = s->tools,
                        .strict = args->strict};
    /* The start was checked when the session was recorded. */
    if (s->resumed)
        return OST_OK;
    /* A path contains the first pose of each of its tools. Without a path, every tool begins at s->home. */
    const bool by_path = s->path.count && (sim_follows_path(args) || args->paths_given);
    if (by_path)
        start_poses(&s->path, site.first);
    for (int i = 0; i < args->tools.count && !by_path; i++)
        site.first[i] = &s->home;
    return start_check(app, &site, &s->site, err);
}

ost_status sim_record_begin(const sim_args *args, simulation *s, ost_error *err)
{
    if (!args->record)
        return OST_OK;
    const session_setup setup = {
        .bone = args->bone,
        .tools = args->tools,
        .ct = args->ct,
        .how = args->how,
        .sweep_off = args->sweep_off,
        .removal_period_ns = args->period_ns,
        .classes = *ost_world_classes(s->world),
        .plan = s->planned ? &s->plan : NULL,
    };
    session_key more[SIM_FORCE_KEYS + 4] = {{"tick_ns", "1000000"}, {"force", sim_force_names[args->force]}};
    sim_force_texts texts;
    sim_force_session(args, &texts, more + 2);
    const ost_recorder_options options = {.capacity = SIM_RECORDER_CAPACITY};
    return session_record(args->record, &setup, s->backend, s->bone, s->tools, args->device, more, &options,
                          &s->recorder, err);
}
