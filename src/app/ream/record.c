/* SPDX-License-Identifier: Apache-2.0 */
/* Records the run of `osteon ream` as a session. */
#include "app/ream/ream.h"

#include <stdio.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "app/session/record.h"

ost_status ream_record_begin(const ream_args *args, ream_job *j, ost_error *err)
{
    if (!args->record)
        return OST_OK;
    const session_setup setup = {
        .bone = args->bone,
        .tools = args->tools,
        .ct = args->ct,
        .how = args->how,
        .sweep_off = args->sweep == 0,
        .removal_period_ns = args->period_ns,
        .classes = *ost_world_classes(j->world),
        .plan = j->planned ? &j->plan : NULL,
    };
    return session_record(args->record, &setup, j->backend, j->bone, j->tools, "path", NULL, NULL, &j->recorder, err);
}

static uint32_t at_most_32(uint64_t n)
{
    return n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
}

ost_status ream_record_tick(ream_job *j, size_t number, const ost_step_result *step, ost_error *err)
{
    const ost_record record = {
        .kind = OST_RECORD_TICK,
        .as.tick = {.number = number,
                    .tick = j->path.ticks[number],
                    .flags = (step->removal ? OST_TICK_REMOVAL : 0) | (step->boxes_meet ? OST_TICK_MET : 0),
                    .digest = ost_step_digest(step, ost_world_classes(j->world)->count),
                    .removed = step->report ? at_most_32(step->report->total_voxels) : 0,
                    .touched = step->report ? at_most_32(step->report->touched_voxels) : 0,
                    .poses = (uint16_t)step->pose_count},
    };
    if (j->recorder)
        ost_recorder_put_waiting(j->recorder, &record);
    return j->debrief.before.voxels ? debrief_tick(&j->debrief, &record.as.tick, err) : OST_OK;
}

void ream_record_note(const ream_job *j, size_t tick, const char *text)
{
    if (!j->recorder)
        return;
    ost_record record = {.kind = OST_RECORD_NOTE, .as.note.t_ns = tick < j->path.count ? j->path.ticks[tick].t_ns : 0};
    snprintf(record.as.note.text, sizeof record.as.note.text, "%s", text);
    ost_recorder_put_waiting(j->recorder, &record);
}

ost_status ream_record_end(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    if (!j->recorder)
        return OST_OK;
    ost_world_totals totals;
    ost_world_totals_get(j->world, &totals);
    const ost_session_end end = {.ticks = totals.ticks,
                                 .removals = totals.removals,
                                 .removed_voxels = totals.removed_voxels,
                                 .has_root = true,
                                 .root = j->root};
    ost_recorder *recorder = j->recorder;
    j->recorder = NULL;
    ost_status status = ost_recorder_close(recorder, &end, err);
    if (status != OST_OK) {
        ost_fail_context(err, "%s is complete, but the recording is not", args->out);
        return status;
    }
    put_text(app->result, "session", args->record);
    print_line(app, "  recorded in %s", args->record);
    return OST_OK;
}
