/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/session_voxels.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/progress.h"
#include "app/replay/replay.h"

enum { GROUP_NS = 20000000 };

typedef struct walk {
    replay replay;
    ost_bone_info info;
    ost_volume known;  /* the bone at the previous call of look() */
    int16_t *slices;   /* owned; buffer of look() */
    int32_t from, to;  /* range of slices that lost voxels since then; to is 0 if there are none */
    int64_t begun_ns, last_ns;
} walk;

void session_voxels_free(session_voxels *v)
{
    free(v->list.t_s);
    free(v->list.voxels);
}

static bool reserve(void **array, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity)
        return true;
    const size_t more = *capacity ? 2 * *capacity : 1024;
    void *grown = realloc(*array, more * size);
    if (!grown)
        return false;
    *array = grown;
    *capacity = more;
    return true;
}

static ost_status record_tick(walk *w, session_voxels *out, ost_error *err)
{
    if (w->to == 0)
        return OST_OK;
    const ost_dims d = w->info.geometry.dims;
    const size_t slice = (size_t)d.x * (size_t)d.y;
    ost_status status = ost_bone_download(w->replay.bone, w->from, w->to - w->from, w->slices, err);
    const size_t before = out->list.count;
    for (int32_t z = w->from; z < w->to && status == OST_OK; z++) {
        int16_t *old = w->known.voxels + slice * (size_t)z;
        const int16_t *now = w->slices + slice * (size_t)(z - w->from);
        if (memcmp(old, now, slice * sizeof *old) == 0)
            continue;
        for (size_t i = 0; i < slice; i++) {
            if (old[i] == now[i])
                continue;
            if (!reserve((void **)&out->list.voxels, &out->capacity, out->list.count, sizeof *out->list.voxels))
                return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu voxels", out->list.count);
            out->list.voxels[out->list.count++] = (ost_session_voxel){
                .at = {(int32_t)(i % (size_t)d.x), (int32_t)(i / (size_t)d.x), z}, .group = (uint32_t)out->list.groups, .density = old[i]};
            old[i] = now[i];
        }
    }
    w->to = 0;
    if (status != OST_OK || out->list.count == before)
        return status;
    if (!reserve((void **)&out->list.t_s, &out->group_capacity, out->list.groups, sizeof *out->list.t_s))
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu groups of voxels", out->list.groups);
    out->list.t_s[out->list.groups++] = (double)w->last_ns * 1e-9;
    return OST_OK;
}

/* Extends the range of slices by the chunks that lost voxels. */
static void mark(walk *w, const ost_step_result *step)
{
    const int64_t layer = (int64_t)w->info.chunk_dims.x * w->info.chunk_dims.y;
    const int32_t n = w->info.chunk_size, last = w->info.geometry.dims.z;
    for (size_t i = 0; step->report && i < step->report->count; i++) {
        const int32_t z = (int32_t)(step->report->chunks[i].chunk / layer) * n, end = z + n < last ? z + n : last;
        w->from = w->to == 0 || z < w->from ? z : w->from;
        w->to = end > w->to ? end : w->to;
    }
}

static ost_status walk_ticks(walk *w, ost_session *session, session_voxels *out, ost_error *err)
{
    const uint64_t count = ost_session_summary_of(session)->complete_ticks;
    ost_status status = OST_OK;
    ost_session_rewind(session);
    for (uint64_t done = 0; done < count && status == OST_OK;) {
        ost_record record;
        ost_step_result step;
        bool more;
        status = ost_session_next(session, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind != OST_RECORD_TICK)
            continue;
        const ost_session_tick *t = &record.as.tick;
        if (done++ == 0 || t->tick.t_ns / GROUP_NS != w->begun_ns / GROUP_NS) {
            status = record_tick(w, out, err);
            w->begun_ns = t->tick.t_ns;
        }
        if (status == OST_OK)
            status = ost_world_step(w->replay.world, &t->tick, &step, err);
        if (status == OST_OK && ost_step_digest(&step, ost_world_classes(w->replay.world)->count) != t->digest)
            status = ost_fail(err, OST_ERR_INPUT, "tick %llu comes out otherwise than recorded; osteon replay --verify says where",
                              (unsigned long long)t->number);
        if (status == OST_OK)
            mark(w, &step);
        w->last_ns = t->tick.t_ns;
        if (done % 64 == 0)
            progress_show(NULL, "looking for voxels", (double)done / (double)count);
    }
    progress_clear();
    return status == OST_OK ? record_tick(w, out, err) : status;
}

ost_status session_voxels_take(const app_state *app, ost_session *session, const char *name, session_voxels *out, ost_error *err)
{
    session_setup setup;
    walk w = {.to = 0};
    progress_begin(app);
    ost_status status = session_keys_read(name, ost_session_header_of(session), &setup, err);
    if (status == OST_OK)
        status = replay_open(app, session, name, &setup, &w.replay, err);
    if (status == OST_OK)
        status = ost_bone_info_get(w.replay.bone, &w.info, err);
    if (status == OST_OK)
        status = ost_volume_init(&w.known, &w.info.geometry, err);
    if (status == OST_OK)
        status = ost_bone_download(w.replay.bone, 0, w.info.geometry.dims.z, w.known.voxels, err);
    if (status == OST_OK) {
        const ost_dims d = w.info.geometry.dims;
        w.slices = malloc((size_t)d.x * (size_t)d.y * (size_t)d.z * sizeof *w.slices);
        status = w.slices ? walk_ticks(&w, session, out, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for a second copy of the bone");
        if (status != OST_OK)
            ost_fail_context(err, "%s", name);
    }
    free(w.slices);
    ost_volume_free(&w.known);
    replay_close(&w.replay);
    return status;
}
