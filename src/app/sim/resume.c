/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/sim.h"

#include "app/common/progress.h"
#include "app/common/print.h"
#include "app/session/keys.h"

ost_status sim_resume_open(const app_state *app, sim_args *args, simulation *s, ost_error *err)
{
    session_setup setup;
    ost_status status = load_session(app, args->resume, &s->resumed, err);
    if (status != OST_OK)
        return status;
    if (ost_session_summary_of(s->resumed)->complete_ticks == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: no tick can be replayed", args->resume);
    status = session_keys_read(args->resume, ost_session_header_of(s->resumed), &setup, err);
    if (status != OST_OK)
        return status;
    args->bone = args->bone_given ? args->bone : setup.bone;
    args->tools = args->tools_given ? args->tools : setup.tools;
    args->ct = setup.ct;
    args->how = setup.how;
    args->sweep_off = setup.sweep_off;
    args->period_ns = setup.removal_period_ns;
    args->classes = setup.classes;
    return OST_OK;
}

ost_status sim_resume_run(const sim_args *args, simulation *s, ost_error *err)
{
    const session_setup names = {.bone = args->bone, .tools = args->tools};
    const uint64_t count = ost_session_summary_of(s->resumed)->complete_ticks;
    ost_status status = session_keys_check(args->resume, ost_session_header_of(s->resumed), &names, s->bone, s->tools,
                                           err);
    while (status == OST_OK && s->before < count) {
        ost_record record;
        ost_step_result step;
        bool more;
        status = ost_session_next(s->resumed, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind == OST_RECORD_TICK) {
            status = ost_world_step(s->world, &record.as.tick.tick, &step, err);
            if (status == OST_OK && ost_step_digest(&step, ost_world_classes(s->world)->count) != record.as.tick.digest)
                status = ost_fail(err, OST_ERR_INPUT, "%s: tick %llu differs from the recording; run osteon replay "
                                  "--verify to find where", args->resume, (unsigned long long)record.as.tick.number);
            s->last = record.as.tick.tick;
            ost_motor_advance(&s->motor, &s->last);
            s->before++;
        }
        if (status == OST_OK && s->recorder && record.kind != OST_RECORD_END)
            ost_recorder_put_waiting(s->recorder, &record);
        if (s->before % 16 == 0)
            progress_show(NULL, "resuming", (double)s->before / (double)count);
    }
    progress_end();
    return status;
}
