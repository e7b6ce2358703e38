/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/report.h"

#include <stdio.h>

#include "app/common/print.h"
#include "app/common/result.h"

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
    ost_status status = replay_open_other(app, here, &other, err);
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

static ost_status print_end(const app_state *app, replay *here, const replay_ending *e, ost_error *err)
{
    uint64_t tick = 0;
    replay_difference difference = {0};
    ost_status status = OST_OK;
    const bool counts = e->end.ticks != e->totals.ticks || e->end.removals != e->totals.removals ||
                        e->end.removed_voxels != e->totals.removed_voxels;
    if (!counts)
        status = replay_find_by_bisection(app, here, &tick, &difference, err);
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

bool replay_verified_in_part(const replay_args *args, const replay *r, const replay_ending *e)
{
    const bool enough = args->ticks_given && (uint64_t)args->ticks <= r->done;
    return args->verify && !r->differs && !e->complete && !enough;
}

ost_status replay_report(app_state *app, const replay_args *args, replay *r, const replay_ending *e, ost_error *err)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], hex[OST_DIGEST_HEX];
    const bool differs = r->differs || replay_end_differs(e);
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
    if (replay_verified_in_part(args, r, e)) {
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
