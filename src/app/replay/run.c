/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/run.h"

#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/debrief/debrief.h"
#include "app/replay/report.h"

static ost_status debrief_take(const app_state *app, const replay_args *args, replay *r, debrief *d, ost_error *err)
{
    ost_metrics_plan plan;
    bool known;
    int tools = 0;
    if (!args->debrief)
        return OST_OK;
    ost_status status = glenoid_plan_find(app, &args->plan, args->session, ost_session_header_of(r->session),
                                          &r->imported.meta, r->setup.bone, true, &plan, &known, err);
    while (tools < OPTION_LIST_MAX && r->tools[tools])
        tools++;
    return status == OST_OK ? debrief_begin(r->bone, &plan, r->tools, tools, d, err) : status;
}

static ost_status film_take(const app_state *app, const replay_args *args, replay *r, replay_film **out, ost_error *err)
{
    ost_metrics_plan plan;
    bool known = false;
    if (!args->film.video.target && !args->film.video.pipe)
        return OST_OK;
    ost_status status = glenoid_plan_find(app, &args->plan, args->session, ost_session_header_of(r->session),
                                          &r->imported.meta, r->setup.bone, false, &plan, &known, err);
    return status == OST_OK ? replay_film_begin(app, &args->film, r, known ? &plan : NULL, out, err) : status;
}

static ost_status write_bone(app_state *app, const replay_args *args, const replay *r, ost_error *err)
{
    const ost_write_options write = {.compress = args->compress, .progress = progress_show};
    ost_digest file;
    ost_status status = ost_bone_write(args->out, r->bone, &r->imported.meta, &write, err);
    if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK) {
        put_text(app->result, "out", args->out);
        put_digest(app->result, "file_sha256", &file);
    }
    return status;
}

static ost_status run(app_state *app, const replay_args *args, replay *r, debrief *d, ost_error *err)
{
    replay_ending e = {0};
    const ost_session_summary *s = ost_session_summary_of(r->session);
    uint64_t count = s->complete_ticks;
    if (args->ticks_given && (uint64_t)args->ticks < count)
        count = (uint64_t)args->ticks;
    ost_status status = replay_run(r, count, true, err);
    if (status == OST_OK)
        status = ost_bone_digest(r->bone, NULL, &e.root, err);
    if (status != OST_OK)
        return status;
    ost_world_totals_get(r->world, &e.totals);
    status = replay_find_end(r->session, &e, err);
    if (status != OST_OK)
        return status;
    e.compared = e.complete && !r->differs && r->done == s->ticks;
    /* the bone is written only if everything was verified and nothing differs */
    if (args->out && !r->differs && !replay_end_differs(&e) && !replay_verified_in_part(args, r, &e))
        status = write_bone(app, args, r, err);
    if (status != OST_OK)
        return status;
    status = replay_report(app, args, r, &e, err);
    if (status == OST_OK && args->debrief) {
        status = debrief_session(d, r->session, r->done, err);
        if (status == OST_OK)
            status = debrief_end(app, d, r->bone, ost_world_classes(r->world), args->session, args->debrief, err);
    }
    return status;
}

/* Opens the replay. --bone and --tool replace the names of files that the session contains. */
static ost_status open_replay(app_state *app, const replay_args *args, ost_session *session, replay *r, ost_error *err)
{
    session_setup setup;
    char missing[OST_SESSION_MISSING];
    ost_status status = OST_OK;
    put_text(app->result, "missing", ost_session_missing(session, missing));
    if (ost_session_summary_of(session)->complete_ticks == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: no tick can be replayed", args->session);
    if (status == OST_OK)
        status = session_keys_read(args->session, ost_session_header_of(session), &setup, err);
    if (status == OST_OK && args->tools.count && args->tools.count != setup.tools.count)
        status = usage_error(app, err, "%d tools given; the session has %d", args->tools.count, setup.tools.count);
    if (status == OST_OK) {
        setup.bone = args->bone ? args->bone : setup.bone;
        setup.tools = args->tools.count ? args->tools : setup.tools;
        status = replay_open(app, session, args->session, &setup, r, err);
    }
    return status;
}

ost_status replay_session(app_state *app, const replay_args *args, ost_error *err)
{
    ost_session *session;
    ost_status status = load_session(app, args->session, &session, err);
    if (status != OST_OK)
        return status;
    replay r = {0};
    status = open_replay(app, args, session, &r, err);
    debrief d = {0};
    replay_film *video = NULL;
    if (status == OST_OK)
        status = film_take(app, args, &r, &video, err);
    if (status == OST_OK)
        status = debrief_take(app, args, &r, &d, err);
    if (status == OST_OK)
        status = run(app, args, &r, &d, err);
    if (status == OST_OK)
        status = replay_film_end(app, video, err);
    replay_film_free(video);
    debrief_free(&d);
    replay_close(&r);
    ost_session_close(session);
    return status;
}
