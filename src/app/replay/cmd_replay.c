/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon replay`: replays a recorded session on any backend.
 *
 * The digest of every tick is compared with the recorded digest. At the end, the counts and the bone's digest are
 * compared as well. With --verify, a difference is also located: the same ticks are run on a second backend, the
 * reference, up to the first tick that differs. A comparison of the two bones then yields the chunk and the voxel. The
 * result, recorded or replayed, that agrees with the reference is the correct one.
 */
#include <string.h>

#include "app/common/backend_choice.h"
#include "app/debrief/debrief.h"
#include "app/input/glenoid_plan.h"
#include "app/common/progress.h"
#include "app/replay/film.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/replay/session_info.h"

typedef struct replay_args {
    const char *session, *bone, *out, *debrief;
    option_list tools;
    glenoid_plan_options plan; /* options of the plan, for the debrief */
    replay_film_options film;
    int64_t ticks;
    bool ticks_given, verify, compress;
} replay_args;

/* The end of a session, as recorded in the file and as reached by the replay. */
typedef struct ending {
    bool found;     /* true if the file contains an end record */
    bool complete;  /* true if the file contains an end record and every tick before it */
    bool compared;  /* true if the replay reached the end of the session, so that the ends were compared */
    uint64_t ticks; /* number of recorded ticks, from the end record or, without one, from the last readable tick */
    ost_session_end end;
    ost_world_totals totals;
    ost_digest root;
} ending;

static ost_status find_end(ost_session *session, ending *e, ost_error *err)
{
    ost_session_rewind(session);
    for (bool more = true; more;) {
        ost_record record;
        ost_status status = ost_session_next(session, &record, &more, err);
        if (status != OST_OK)
            return status;
        if (more && record.kind == OST_RECORD_END) {
            e->found = true;
            e->end = record.as.end;
        }
    }
    const ost_session_summary *s = ost_session_summary_of(session);
    const bool missing = s->missing_records || s->lost_records || s->damaged_bytes || s->cut_bytes;
    e->ticks = s->ticks ? s->last_tick + 1 : 0;
    e->ticks = s->ticks > e->ticks ? s->ticks : e->ticks;
    if (missing && e->found && e->end.ticks > e->ticks)
        e->ticks = e->end.ticks;
    e->complete = e->found && s->complete_ticks == e->ticks;
    return OST_OK;
}

static bool end_differs(const ending *e)
{
    return e->compared && (e->end.ticks != e->totals.ticks || e->end.removals != e->totals.removals ||
                           e->end.removed_voxels != e->totals.removed_voxels ||
                           (e->end.has_root && !ost_digest_equal(&e->end.root, &e->root)));
}

/* Opens the session on another backend: the reference, or cpu if the first backend is the reference. */
static ost_status open_other(const app_state *app, const replay *here, replay *other, ost_error *err)
{
    app_state second = *app;
    second.backend = strcmp(ost_backend_name(here->backend), "ref") == 0 ? "cpu" : "ref";
    second.threads = 0;
    ost_status status = replay_open(&second, here->session, here->name, &here->setup, other, err);
    if (status != OST_OK)
        ost_fail_context(err, "searching for the first difference");
    return status;
}

/* Replays the first `ticks` ticks of the session on both backends, and then compares the bones. */
static ost_status differ_after(const app_state *app, const replay *model, uint64_t ticks, replay_difference *difference,
                               ost_error *err)
{
    replay here = {0}, other = {0};
    ost_status status = replay_open(app, model->session, model->name, &model->setup, &here, err);
    if (status == OST_OK)
        status = open_other(app, &here, &other, err);
    if (status == OST_OK)
        status = replay_run(&here, ticks, false, err);
    if (status == OST_OK)
        status = replay_run(&other, ticks, false, err);
    if (status == OST_OK)
        status = replay_compare_bones(&here, &other, difference, err);
    replay_close(&other);
    replay_close(&here);
    return status;
}

/*
 * Finds the first tick after which the bones of two backends differ, by bisection. Called if the bones differ although
 * the digests of all ticks are equal.
 */
static ost_status find_by_halving(const app_state *app, const replay *here, uint64_t *tick,
                                  replay_difference *difference, ost_error *err)
{
    uint64_t equal = 0, unequal = here->done;
    ost_status status = differ_after(app, here, unequal, difference, err);
    while (status == OST_OK && difference->found && unequal - equal > 1) {
        replay_difference middle;
        const uint64_t half = equal + (unequal - equal) / 2;
        status = differ_after(app, here, half, &middle, err);
        if (middle.found) {
            unequal = half;
            *difference = middle;
        } else {
            equal = half;
        }
    }
    *tick = unequal - 1;
    return status;
}

static void put_difference(json_t *o, const replay_difference *difference)
{
    put_integer(o, "chunk", difference->chunk);
    put(o, "voxel", json_pack("[i,i,i]", difference->voxel[0], difference->voxel[1], difference->voxel[2]));
    put_integer(o, "density_here", difference->here);
    put_integer(o, "density_there", difference->there);
    put_integer(o, "different_voxels", (int64_t)difference->voxels);
}

/* Stores the chunks that lost voxels in the tick. The recording contains only the digest of these chunks. */
static void put_chunks(json_t *o, const replay *r)
{
    json_t *array = json_array();
    for (size_t i = 0; r->step.report && i < r->step.report->count; i++)
        append(array, json_integer(r->step.report->chunks[i].chunk));
    put(o, "chunks", array);
}

static void put_hex(json_t *o, const char *key, uint64_t value)
{
    char text[20];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)value);
    put_text(o, key, text);
}

static ost_status print_tick(const app_state *app, replay *here, ost_error *err)
{
    replay other = {0};
    replay_difference difference = {0};
    const ost_session_tick *t = &here->recorded;
    ost_status status = open_other(app, here, &other, err);
    if (status == OST_OK)
        status = replay_run(&other, here->done, false, err);
    if (status == OST_OK)
        status = replay_compare_bones(here, &other, &difference, err);
    if (status != OST_OK) {
        replay_close(&other);
        return status;
    }
    const char *name = ost_backend_name(here->backend), *second = ost_backend_name(other.backend);
    const bool recording_right = replay_as_recorded(&other, t);
    const uint64_t removed = here->step.report ? here->step.report->total_voxels : 0;
    json_t *o = json_object();
    put_integer(o, "tick", (int64_t)t->number);
    put_real(o, "t_s", (double)t->tick.t_ns * 1e-9);
    put_integer(o, "tool", t->tick.tool);
    put_integer(o, "removed_voxels", (int64_t)removed);
    put_integer(o, "recorded_removed_voxels", t->removed);
    put_hex(o, "digest", here->digest);
    put_hex(o, "recorded_digest", t->digest);
    put_text(o, "other_backend", second);
    put_bool(o, "other_agrees_with_recording", recording_right);
    if (difference.found)
        put_difference(o, &difference);
    else
        put_chunks(o, here);
    put(app->result, "first_difference", o);
    if (difference.found)
        ost_fail(err, OST_ERR_DIFFER,
                 "%s: differs from tick %llu on: %s removed %llu voxels there, recorded are %u; chunk %lld, voxel (%d, "
                 "%d, %d) is %d with %s and %d "
                 "with %s, which %s with the recording",
                 here->name, (unsigned long long)t->number, name, (unsigned long long)removed, (unsigned)t->removed,
                 (long long)difference.chunk, difference.voxel[0], difference.voxel[1], difference.voxel[2],
                 difference.here, name, difference.there, second, recording_right ? "agrees" : "does not agree either");
    else
        ost_fail(err, OST_ERR_DIFFER,
                 "%s: differs from tick %llu on: removed were %llu voxels, recorded are %u; %s and %s agree on every "
                 "voxel, so the recording itself differs", here->name, (unsigned long long)t->number,
                 (unsigned long long)removed, (unsigned)t->removed, name, second);
    replay_close(&other);
    return OST_ERR_DIFFER;
}

static ost_status print_end(const app_state *app, replay *here, const ending *e, ost_error *err)
{
    uint64_t tick = 0;
    replay_difference difference = {0};
    ost_status status = OST_OK;
    const bool counts = e->end.ticks != e->totals.ticks || e->end.removals != e->totals.removals ||
                        e->end.removed_voxels != e->totals.removed_voxels;
    if (!counts)
        status = find_by_halving(app, here, &tick, &difference, err);
    if (status != OST_OK)
        return status;
    json_t *o = json_object();
    put_text(o, "at", "end");
    if (difference.found) {
        put_integer(o, "tick", (int64_t)tick);
        put_difference(o, &difference);
        ost_fail(err, OST_ERR_DIFFER,
                 "%s: every tick removed as many voxels as recorded, but not the same: from tick %llu on, chunk %lld, "
                 "voxel (%d, %d, %d) is %d and "
                 "should be %d",
                 here->name, (unsigned long long)tick, (long long)difference.chunk, difference.voxel[0],
                 difference.voxel[1], difference.voxel[2], difference.here, difference.there);
    } else if (counts) {
        ost_fail(err, OST_ERR_DIFFER, "%s: every tick is as recorded, but the totals are %llu ticks and %llu voxels; "
                 "recorded are %llu and %llu", here->name, (unsigned long long)e->totals.ticks,
                 (unsigned long long)e->totals.removed_voxels, (unsigned long long)e->end.ticks,
                 (unsigned long long)e->end.removed_voxels);
    } else {
        ost_fail(err, OST_ERR_DIFFER, "%s: every tick is as recorded, but the bone at the end is not; two backends "
                 "agree on it, so the recording itself differs", here->name);
    }
    put(app->result, "first_difference", o);
    return OST_ERR_DIFFER;
}

/* Reports a difference if --verify is not given. The report names the tick but not the position. */
static ost_status print_briefly(const app_state *app, const replay *here, ost_error *err)
{
    json_t *o = json_object();
    if (here->differs)
        put_integer(o, "tick", (int64_t)here->recorded.number);
    else
        put_text(o, "at", "end");
    put(app->result, "first_difference", o);
    if (here->differs)
        return ost_fail(err, OST_ERR_DIFFER,
                        "%s: differs from what was recorded from tick %llu on; pass --verify to find where",
                        here->name, (unsigned long long)here->recorded.number);
    return ost_fail(err, OST_ERR_DIFFER,
                    "%s: every tick is as recorded, but the end is not; pass --verify to find where", here->name);
}

/*
 * Returns true if --verify found no difference, but the file is incomplete and contains fewer ticks than were
 * requested.
 */
static bool verified_in_part(const replay_args *args, const replay *r, const ending *e)
{
    const bool enough = args->ticks_given && (uint64_t)args->ticks <= r->done;
    return args->verify && !r->differs && !e->complete && !enough;
}

static ost_status report(app_state *app, const replay_args *args, replay *r, const ending *e, ost_error *err)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], hex[OST_DIGEST_HEX];
    const bool differs = r->differs || end_differs(e);
    json_t *o = app->result;
    put_text(o, "session", args->session);
    put_text(o, "backend", ost_backend_name(r->backend));
    put_integer(o, "ticks", (int64_t)r->done);
    put_integer(o, "verified_ticks", (int64_t)(r->differs ? r->done - 1 : r->done));
    put_integer(o, "recorded_ticks", (int64_t)e->ticks);
    put_bool(o, "complete", e->complete);
    put_bool(o, "equal", !differs);
    put_bool(o, "end_compared", e->compared);
    put_integer(o, "removed_voxels", (int64_t)e->totals.removed_voxels);
    put_digest(o, "sha256", &e->root);
    if (!differs)
        put(o, "first_difference", json_null());
    print_line(app, "%s: %s ticks replayed with %s, %s voxels removed", args->session, format_count(a,
               (int64_t)r->done), ost_backend_name(r->backend), format_count(b, (int64_t)e->totals.removed_voxels));
    print_line(app, "  grid %s", ost_digest_hex(&e->root, hex));
    if (verified_in_part(args, r, e)) {
        char of[32] = ""; /* the number of recorded ticks is known only if the file has an end record */
        if (e->found)
            snprintf(of, sizeof of, "of %llu ", (unsigned long long)e->ticks);
        app->answered = true;
        return ost_fail(
            err, OST_ERR_INPUT, "%s: the first %llu %sticks are equal; the recording is incomplete after them",
            args->session, (unsigned long long)r->done, of);
    }
    if (!differs) {
        print_line(app, e->compared ? "  every tick and the bone at the end are as recorded"
                                    : "  every tick is as recorded");
        return OST_OK;
    }
    ost_status status = !args->verify ? print_briefly(app, r, err)
                        : r->differs  ? print_tick(app, r, err)
                                      : print_end(app, r, e, err);
    if (status == OST_ERR_DIFFER)
        print_line(app, "%s", err->text);
    return status;
}

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

static ost_status run(app_state *app, const replay_args *args, replay *r, debrief *d, ost_error *err)
{
    ending e = {0};
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
    status = find_end(r->session, &e, err);
    if (status != OST_OK)
        return status;
    e.compared = e.complete && !r->differs && r->done == s->ticks;
    /* the bone is written only if everything was verified and nothing differs */
    if (args->out && !r->differs && !end_differs(&e) && !verified_in_part(args, r, &e)) {
        const ost_write_options write = {.compress = args->compress, .progress = progress_show};
        ost_digest file;
        status = ost_bone_write(args->out, r->bone, &r->imported.meta, &write, err);
        if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK) {
            put_text(app->result, "out", args->out);
            put_digest(app->result, "file_sha256", &file);
        }
        if (status != OST_OK)
            return status;
    }
    status = report(app, args, r, &e, err);
    if (status == OST_OK && args->debrief) {
        status = debrief_session(d, r->session, r->done, err);
        if (status == OST_OK)
            status = debrief_end(app, d, r->bone, ost_world_classes(r->world), args->session, args->debrief, err);
    }
    return status;
}

ost_status cmd_replay(app_state *app, int argc, char **argv, ost_error *err)
{
    replay_args args = {.film.video.fps = 30};
    target_options *t = &args.plan.target;
    const operand operands[] = {{"SESSION", &args.session, "no session given"}, {0}};
    const option options[] = {
        {.name = "verify",
         .kind = OPTION_FLAG,
         .out = &args.verify,
         .help = "compare up to the end of the recording; if something differs, find the tick, chunk and voxel "
                 "with a second backend"},
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .help = "the bone after the last tick: .nrrd, .nii, .nii.gz or .txt"},
        {.name = "ticks",
         .kind = OPTION_INTEGER,
         .out = &args.ticks,
         .given = &args.ticks_given,
         .value = "N",
         .min = 1,
         .max = INT64_MAX,
         .help = "repeat only the first N ticks"},
        {.name = "bone",
         .kind = OPTION_TEXT,
         .out = &args.bone,
         .value = "BONE",
         .help = "where the bone is now (default: where it was recorded)"},
        {.name = "tool",
         .kind = OPTION_LIST,
         .out = &args.tools,
         .value = "TOOL",
         .help = "where the tools are now, in order; may repeat (default: where they were recorded)"},
        {.name = "debrief",
         .kind = OPTION_OUTPUT,
         .out = &args.debrief,
         .value = "FILE.html",
         .help = "page that compares the result with the plan: angles, depths, hole, seat, force, pictures"},
        COMPRESS_OPTION(args.compress),
        HEADING("glenoid and plan, for --debrief"),
        TARGET_OPTIONS(*t, "centre of the glenoid's face (default: as in the session, else as in the bone's file)"),
        GLENOID_PLAN_OPTIONS(args.plan),
        HEADING("video and its appearance"),
        REPLAY_FILM_OPTIONS(args.film),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "SESSION [--verify] [--out FILE] [options]",
        .about = "Repeats a recorded session tick by tick on any backend and compares the result\n"
                 "of each tick with the recording. Exit status 1 if something differs; with\n"
                 "--verify, exit status 2 if everything in the file is equal but ticks or the end\n"
                 "are missing.",
        .operands = operands,
        .options = options,
        .notes = "A session that was cut off or damaged is repeated up to the first missing tick.",
        .example = "  osteon ream --bone builtin:glenoid --tool builtin:reamer --path builtin:glenoid-ream \\\n"
                   "    --out reamed.nrrd --record today.session\n"
                   "  osteon replay today.session --verify --backend ref\n"
                   "  osteon replay today.session --ticks 2000 --out halfway.nrrd\n"
                   "  osteon replay today.session --video today.mp4",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.out && (status = out_check(app, args.out, "nrrd|nii|nii.gz|txt", err)) != OST_OK)
        return status;
    if (args.debrief && (status = out_check(app, args.debrief, "html", err)) != OST_OK)
        return status;
    if ((status = replay_film_check(app, &args.film, err)) != OST_OK)
        return status;
    ost_session *session;
    status = load_session(app, args.session, &session, err);
    if (status != OST_OK)
        return status;
    session_setup setup;
    replay r = {0};
    char missing[OST_SESSION_MISSING];
    put_text(app->result, "missing", ost_session_missing(session, missing));
    if (ost_session_summary_of(session)->complete_ticks == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: no tick can be replayed", args.session);
    if (status == OST_OK)
        status = session_keys_read(args.session, ost_session_header_of(session), &setup, err);
    if (status == OST_OK && args.tools.count && args.tools.count != setup.tools.count)
        status = usage_error(app, err, "%d tools given; the session has %d", args.tools.count, setup.tools.count);
    if (status == OST_OK) {
        setup.bone = args.bone ? args.bone : setup.bone;
        setup.tools = args.tools.count ? args.tools : setup.tools;
        status = replay_open(app, session, args.session, &setup, &r, err);
    }
    debrief d = {0};
    replay_film *video = NULL;
    if (status == OST_OK)
        status = film_take(app, &args, &r, &video, err);
    if (status == OST_OK)
        status = debrief_take(app, &args, &r, &d, err);
    if (status == OST_OK)
        status = run(app, &args, &r, &d, err);
    if (status == OST_OK)
        status = replay_film_end(app, video, err);
    replay_film_free(video);
    debrief_free(&d);
    replay_close(&r);
    ost_session_close(session);
    return status;
}
