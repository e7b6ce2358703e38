/* SPDX-License-Identifier: Apache-2.0 */
/* Executes the ticks. If an OpenCL device fails, the `cpu` backend continues from the last complete tick. */
#include "app/ream/ream.h"

#include <stdio.h>
#include <stdlib.h>

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

bool ream_may_fail_over(const app_state *app, const ream_args *args, const ream_job *j, ost_status status)
{
    return backend_is(app, "cl") && !args->no_failover && !j->failed_over &&
           (status == OST_ERR_UNAVAILABLE || status == OST_ERR_MEMORY || status == OST_ERR_INTERNAL);
}

ost_status ream_fail_over(const app_state *app, ream_job *j, size_t ticks, ost_error *err)
{
    ost_tool *tools[OST_WORLD_TOOLS_MAX];
    ost_bone *bone = NULL;
    ost_backend *cpu = NULL;
    ost_error why = {0};
    char spec[40] = "cpu";
    if (app->threads)
        snprintf(spec, sizeof spec, "cpu:threads=%lld", (long long)app->threads);
    ost_status status = ost_backend_open(spec, &cpu, &why);
    if (status == OST_OK)
        status = ost_world_failover(j->world, cpu, &bone, tools, &why);
    if (status != OST_OK) {
        ost_backend_close(cpu);
        char text[OST_ERROR_TEXT];
        snprintf(text, sizeof text, "%s", err->text);
        return ost_fail(err, status, "%.300s; failover to backend cpu failed: %.280s", text, why.text);
    }
    for (int i = 0; i < OPTION_LIST_MAX; i++) {
        ost_tool_free(j->tools[i]);
        j->tools[i] = i < OST_WORLD_TOOLS_MAX ? tools[i] : NULL;
    }
    ost_bone_free(j->bone);
    ost_backend_close(j->backend);
    j->bone = bone;
    j->backend = cpu;
    j->failed_over = true;
    warn(app, "%s; failover to backend cpu after %zu complete ticks; the result is the same", err->text, ticks);
    ream_record_note(j, ticks, "the device failed; backend cpu continues");
    put(app->result, "failover", json_pack("{s:I,s:s}", "ticks", (json_int_t)ticks, "reason", err->text));
    *err = (ost_error){0};
    return OST_OK;
}

ost_status ream_run(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    ost_status status = OST_OK;
    j->tick_ns = malloc(j->path.count * sizeof *j->tick_ns);
    if (!j->tick_ns)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of %zu ticks", j->path.count);
    double start = now_ms();
    for (size_t i = 0; i < j->path.count; i++) {
        ost_step_result step;
        double before = now_ms();
        status = ost_world_step(j->world, &j->path.ticks[i], &step, err);
        if (ream_may_fail_over(app, args, j, status) && (status = ream_fail_over(app, j, i, err)) == OST_OK)
            status = ost_world_step(j->world, &j->path.ticks[i], &step, err);
        double ns = (now_ms() - before) * 1e6;
        if (status != OST_OK) {
            ost_fail_context(err, "%s: tick %zu at %.6f s", args->paths.count == 1 ? args->paths.value[0] : "path", i,
                             (double)j->path.ticks[i].t_ns * 1e-9);
            break;
        }
        j->tick_ns[i] = ns < 4e9 ? (uint32_t)ns : UINT32_MAX;
        if ((j->recorder || args->debrief) && (status = ream_record_tick(j, i, &step, err)) != OST_OK)
            break;
        j->met |= step.removal && step.boxes_meet;
        if (i % 16 == 0)
            progress_show(NULL, "reaming", (double)i / (double)j->path.count);
    }
    if (status == OST_OK) {
        status = ost_backend_finish(j->backend, err);
        if (ream_may_fail_over(app, args, j, status))
            status = ream_fail_over(app, j, j->path.count, err);
    }
    j->run_ms = now_ms() - start;
    progress_end();
    return status;
}
