/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/verify.h"

#include <string.h>

ost_status replay_find_end(ost_session *session, replay_ending *e, ost_error *err)
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

bool replay_end_differs(const replay_ending *e)
{
    return e->compared && (e->end.ticks != e->totals.ticks || e->end.removals != e->totals.removals ||
                           e->end.removed_voxels != e->totals.removed_voxels ||
                           (e->end.has_root && !ost_digest_equal(&e->end.root, &e->root)));
}

ost_status replay_open_other(const app_state *app, const replay *here, replay *other, ost_error *err)
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
        status = replay_open_other(app, &here, &other, err);
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

ost_status replay_find_by_bisection(const app_state *app, const replay *here, uint64_t *tick,
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
