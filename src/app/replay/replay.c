/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/replay.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/backend_choice.h"
#include "app/common/progress.h"

static ost_status make_world(replay *r, ost_error *err)
{
    const ost_world_options options = {
        .sweep_off = r->setup.sweep_off,
        .removal_period_ns = r->setup.removal_period_ns,
        .classes = r->setup.classes,
    };
    ost_status status = ost_world_create(r->bone, &options, &r->world, err);
    for (int i = 0; i < r->setup.tools.count && status == OST_OK; i++)
        status = ost_world_add_tool(r->world, r->setup.tools.value[i], r->tools[i], NULL, err);
    return status;
}

ost_status replay_open(const app_state *app, ost_session *session, const char *name, const session_setup *setup,
                       replay *out, ost_error *err)
{
    *out = (replay){.session = session, .name = name, .setup = *setup};
    ost_status status = backend_choose(app, &out->backend, err);
    for (int i = 0; i < setup->tools.count && status == OST_OK; i++)
        status = load_tool(app, out->backend, setup->tools.value[i], NULL, &setup->how, &out->tools[i], NULL, err);
    if (status == OST_OK)
        status = load_bone(app, out->backend, setup->bone, &setup->ct, false, &out->bone, &out->imported, err);
    if (status == OST_OK)
        status = session_keys_check(name, ost_session_header_of(session), setup, out->bone, out->tools, err);
    return status == OST_OK ? make_world(out, err) : status;
}

void replay_close(replay *r)
{
    ost_world_free(r->world);
    for (int i = 0; i < OPTION_LIST_MAX; i++)
        ost_tool_free(r->tools[i]);
    ost_bone_free(r->bone);
    ost_backend_close(r->backend);
    *r = (replay){0};
}

static uint32_t at_most_32(uint64_t n)
{
    return n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
}

/*
 * Returns true if the result of the latest step equals the recorded result. Compares the digest and the other
 * fields of a recorded tick.
 */
bool replay_as_recorded(const replay *r, const ost_session_tick *tick)
{
    const ost_step_result *step = &r->step;
    const uint32_t flags = (step->removal ? OST_TICK_REMOVAL : 0) | (step->boxes_meet ? OST_TICK_MET : 0);
    return r->digest == tick->digest && step->pose_count == tick->poses &&
           flags == (tick->flags & (OST_TICK_REMOVAL | OST_TICK_MET)) &&
           tick->removed == (step->report ? at_most_32(step->report->total_voxels) : 0) &&
           tick->touched == (step->report ? at_most_32(step->report->touched_voxels) : 0);
}

ost_status replay_run(replay *r, uint64_t count, bool compare, ost_error *err)
{
    const int classes = ost_world_classes(r->world)->count;
    ost_status status = OST_OK;
    ost_session_rewind(r->session);
    while (r->done < count && !r->differs) {
        ost_record record;
        bool more;
        status = ost_session_next(r->session, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind != OST_RECORD_TICK)
            continue;
        status = ost_world_step(r->world, &record.as.tick.tick, &r->step, err);
        if (status != OST_OK) {
            ost_fail_context(err, "%s: tick %llu", r->name, (unsigned long long)record.as.tick.number);
            break;
        }
        r->digest = ost_step_digest(&r->step, classes);
        r->recorded = record.as.tick;
        r->differs = compare && !replay_as_recorded(r, &r->recorded);
        if (r->each && (status = r->each(r->each_user, &r->recorded, &r->step, err)) != OST_OK)
            break;
        if (r->done++ % 16 == 0)
            progress_show(NULL, "replaying", (double)r->done / (double)count);
    }
    if (status == OST_OK)
        status = ost_backend_finish(r->backend, err);
    progress_end();
    return status;
}

/* ------------------------------------------------------------ two bones */

static void compare_slice(const ost_bone_info *info, int32_t k, const int16_t *here, const int16_t *there,
                          replay_difference *out)
{
    const ost_dims d = info->geometry.dims, chunks = info->chunk_dims;
    const int n = info->chunk_size;
    for (int32_t j = 0; j < d.y; j++) {
        const size_t row = (size_t)j * (size_t)d.x;
        if (memcmp(here + row, there + row, (size_t)d.x * sizeof *here) == 0)
            continue;
        for (int32_t i = 0; i < d.x; i++) {
            if (here[row + (size_t)i] == there[row + (size_t)i])
                continue;
            out->voxels++;
            const int64_t chunk = i / n + (int64_t)chunks.x * (j / n + (int64_t)chunks.y * (k / n));
            /* Slices are processed in order, so the first difference found in a chunk has the lowest voxel index of
             * this chunk. */
            if (out->found && chunk >= out->chunk)
                continue;
            *out = (replay_difference){.found = true,
                                       .chunk = chunk,
                                       .voxel = {i, j, k},
                                       .here = here[row + (size_t)i],
                                       .there = there[row + (size_t)i],
                                       .voxels = out->voxels};
        }
    }
}

ost_status replay_compare_bones(const replay *here, const replay *there, replay_difference *out, ost_error *err)
{
    *out = (replay_difference){0};
    ost_bone_info info;
    ost_status status = ost_bone_info_get(here->bone, &info, err);
    if (status != OST_OK)
        return status;
    const ost_dims d = info.geometry.dims;
    const size_t slice = (size_t)d.x * (size_t)d.y;
    int16_t *a = malloc(slice * sizeof *a), *b = malloc(slice * sizeof *b);
    if (!a || !b)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for two slices of %zu voxels", slice);
    for (int32_t k = 0; k < d.z && status == OST_OK; k++) {
        status = ost_bone_download(here->bone, k, 1, a, err);
        if (status == OST_OK)
            status = ost_bone_download(there->bone, k, 1, b, err);
        if (status == OST_OK && memcmp(a, b, slice * sizeof *a) != 0)
            compare_slice(&info, k, a, b, out);
    }
    free(a);
    free(b);
    return status;
}
