/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/film/frame_size.h"
#include "app/common/options.h"
#include "app/picture/tool.h"
#include "app/sim/facts.h"
#include "render/viewer.h"
#include "render/views.h"

enum { PLANNED_MM = 3 }; /* planned depth in mm if neither the session nor an option states one */

struct replay_film {
    const replay_film_options *options;
    film *film;
    ost_live_channel *live;
    ost_viewer viewer;
    appearance look;
    ost_tool_volume ghost_tool; /* volume of the first tool, for drawing this tool as a ghost */
    sim_hud *hud;
    sim_scene scene;
    ost_orbit orbit;
    ost_view_subject subject;
    uint64_t ticks, removals, removed, missed;
    int64_t t_ns;
    double reached_mm[OST_LIVE_TOOLS];
};

ost_status replay_film_check(const app_state *app, replay_film_options *options, ost_error *err)
{
    options->video.wait = true;
    ost_status status = film_check(app, &options->video, err);
    if (status == OST_OK)
        status = appearance_check(app, &options->look, err);
    return status == OST_OK ? frame_size(app, options->size, &options->width, &options->height, err) : status;
}

static ost_status draw(replay_film *f, ost_error *err)
{
    const int width = f->options->width, height = f->options->height;
    ost_camera camera;
    ost_status status = ost_live_flush(f->live, err);
    if (status == OST_OK)
        status = ost_viewer_update(&f->viewer, err);
    const ost_orbit orbit = f->options->view == OST_VIEW_TOOL
                                ? ost_view_orbit(OST_VIEW_TOOL, &f->subject, &f->viewer.state.pose)
                                : f->orbit;
    if (status == OST_OK)
        status = ost_orbit_camera(&orbit, width, height, &camera, err);
    if (status == OST_OK)
        status = ost_viewer_draw(&f->viewer, &camera, err);
    if (status != OST_OK)
        return status;
    const ost_sheet sheet = ost_frame_sheet(&f->viewer.frame);
    double back[3];
    sim_hud_facts facts = sim_facts_make(&f->scene, &f->viewer.state, true);
    facts.plain = true;
    if (!f->options->look.no_legend)
        facts.legend = appearance_legend_of(&f->look);
    facts.mm_per_pixel = orbit.distance / (OST_VIEW_FOCAL * height);
    ost_orbit_frame(&orbit, facts.right, facts.up, back);
    sim_hud_draw(f->hud, &sheet, &facts);
    film_frame(f->film, f->t_ns, sheet.pixels, sheet.stride, width, height);
    return OST_OK;
}

static ost_status on_tick(void *user, const ost_session_tick *tick, const ost_step_result *step, ost_error *err)
{
    replay_film *f = user;
    f->ticks++;
    f->removals += step->removal;
    f->removed += step->report ? step->report->total_voxels : 0;
    f->missed += tick->missed;
    f->t_ns = tick->tick.t_ns;
    ost_live_state state = {.ticks = f->ticks,
                            .t_ns = f->t_ns,
                            .tool = tick->tick.tool,
                            .device = tick->tick.pose,
                            .pose = tick->tick.pose,
                            .removals = f->removals,
                            .removed_voxels = f->removed,
                            .missed = f->missed,
                            .wake_ns = tick->wake_ns,
                            .exec_ns = tick->exec_ns,
                            .touching = tick->removed + tick->touched,
                            .fault = tick->fault};
    double square = 0;
    for (int a = 0; a < 3; a++) {
        state.force_n[a] = tick->force_un[a] * 1e-6;
        square += state.force_n[a] * state.force_n[a];
        f->scene.force_given = f->scene.force_given || tick->force_un[a] != 0;
    }
    /* A session records the hand force, which is the contact force multiplied by the scale and limited to the device's
       maximum. Here, the contact force is computed from the hand force. */
    state.contact_n = sqrt(square) * f->scene.contact_full_n / f->scene.device_full_n;
    const int32_t tool = tick->tick.tool;
    if (tool >= 0 && tool < OST_LIVE_TOOLS && step->report && step->report->total_voxels)
        f->reached_mm[tool] = fmax(f->reached_mm[tool], sim_scene_depth(&f->scene, tool, &tick->tick.pose));
    memcpy(state.reached_mm, f->reached_mm, sizeof state.reached_mm);
    ost_live_changed(f->live, step->report);
    ost_status status = ost_live_publish(f->live, &state, err);
    return status == OST_OK && film_is_due(f->film, f->t_ns) ? draw(f, err) : status;
}

/* Reads the scales of the forces from the session's header. If the header contains none, the defaults remain. */
static void take_forces(replay_film *f, const ost_session_header *header)
{
    const char *max = ost_session_header_get(header, "force.max_force"),
               *scale = ost_session_header_get(header, "force.scale");
    ost_decimal a, b;
    int64_t n, s;
    if (max && scale && ost_decimal_read(max, max + strlen(max), &a) &&
        ost_decimal_read(scale, scale + strlen(scale), &b) && ost_decimal_scale(&a, 1000000, &n, NULL) &&
        ost_decimal_scale(&b, 1000000000, &s, NULL) && n > 0 && s > 0)
        sim_scene_forces(&f->scene, (double)n * 1e-6, (double)s * 1e-9);
}

/* Sets the uncut surface and the appearance, as `osteon sim` does. */
static ost_status make_appearance(replay_film *f, const replay *r, const ost_metrics_plan *plan, ost_error *err)
{
    ost_bone_info info;
    ost_volume uncut = {0};
    double right[3], up[3], eye[3];
    ost_status status = ost_bone_info_get(r->bone, &info, err);
    if (status == OST_OK)
        status = bone_to_volume(r->bone, NULL, &uncut, err);
    if (status == OST_OK)
        status = ost_viewer_set_uncut(&f->viewer, &uncut, info.threshold, ost_world_classes(r->world),
                                      plan ? &plan->at : NULL, plan ? plan->axis : NULL, err);
    ost_volume_free(&uncut);
    if (status == OST_OK)
        status = ost_tool_download(r->tools[0], &f->ghost_tool, err);
    if (status != OST_OK)
        return status;
    ost_viewer_set_contact(&f->viewer, f->options->contact);
    ost_orbit_frame(&f->orbit, right, up, eye);
    for (int a = 0; a < 3; a++)
        eye[a] = f->orbit.at[a] + f->orbit.distance * eye[a];
    return appearance_begin(&f->look, &f->viewer, &f->subject, plan ? plan->depth_mm : PLANNED_MM, &f->ghost_tool,
                            &f->options->look, eye, err);
}

static ost_status add_tools(replay_film *f, const replay *r, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < r->setup.tools.count && status == OST_OK; i++)
        status = picture_add_tool(&f->viewer, r->tools[i], r->setup.tools.value[i], &r->setup.how, err);
    return status;
}

ost_status replay_film_begin(const app_state *app, const replay_film_options *options, replay *r,
                             const ost_metrics_plan *plan, replay_film **out, ost_error *err)
{
    *out = NULL;
    if (!options->video.target && !options->video.pipe)
        return OST_OK;
    replay_film *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a video");
    f->options = options;
    ost_status status = ost_live_create(r->bone, &f->live, err);
    if (status == OST_OK)
        status = ost_viewer_init(&f->viewer, ost_live_geometry(f->live),
                                 options->style ? OST_STYLE_FACES : OST_STYLE_SMOOTH, NULL, (int)app->threads, err);
    if (status == OST_OK)
        status = add_tools(f, r, err);
    const ost_geometry *g = status == OST_OK ? ost_live_geometry(f->live) : NULL;
    if (status == OST_OK) {
        f->subject = ost_view_subject_make(g, plan ? &plan->at : NULL, plan ? plan->axis : NULL, plan && plan->left);
        f->orbit = ost_view_orbit((ost_view_name)options->view, &f->subject, NULL);
        status = make_appearance(f, r, plan, err);
    }
    if (status == OST_OK)
        status = sim_scene_make(&f->scene, &r->setup.tools, r->tools, g, plan, err);
    if (status == OST_OK)
        status = sim_hud_create(options->width, options->height, 1, &f->hud, err);
    if (status == OST_OK)
        status = film_open(&options->video, &f->film, err);
    if (status != OST_OK) {
        replay_film_free(f);
        return status;
    }
    ost_viewer_follow(&f->viewer, f->live);
    take_forces(f, ost_session_header_of(r->session));
    f->scene.device = "";
    f->scene.recording = true;
    r->each = on_tick;
    r->each_user = f;
    *out = f;
    return OST_OK;
}

ost_status replay_film_end(const app_state *app, replay_film *f, ost_error *err)
{
    film_report report;
    if (!f)
        return OST_OK;
    film *video = f->film;
    f->film = NULL;
    const ost_status status = film_close(video, f->t_ns, &report, err);
    if (status == OST_OK)
        film_print_report(app, &f->options->video, &report);
    return status;
}

void replay_film_free(replay_film *f)
{
    if (!f)
        return;
    film_close(f->film, 0, NULL, NULL);
    sim_hud_free(f->hud);
    appearance_free(&f->look);
    ost_tool_volume_free(&f->ghost_tool);
    ost_viewer_free(&f->viewer);
    ost_live_free(f->live);
    free(f);
}
