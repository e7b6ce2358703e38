/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon's own removal event, called through the same table of functions as the other methods. It runs on the
 * processor's backend, or on the backend cl with the device of the other methods. Before an event is timed,
 * ost_bone_collide compares the restored bone once with the tool. This changes no voxel and loads the event's data into
 * the caches.
 */
#include <stdio.h>
#include <stdlib.h>

#include "reproduction/methods/device.h"

typedef struct own_event {
    const methods_scene *scene;
    ost_backend *backend;
    ost_tool *tool;
    ost_bone *bone;
    ost_removal_report report;
} own_event;

static void close_own(void *state)
{
    own_event *s = state;
    ost_removal_report_free(&s->report);
    ost_bone_free(s->bone);
    ost_tool_free(s->tool);
    ost_backend_close(s->backend);
    free(s);
}

static ost_status open_on(ost_backend *backend, const methods_scene *scene, int chunk_size, void **state,
                          ost_error *err)
{
    enum { SLAB = 64 };
    const ost_dims d = scene->event.bone.dims;
    own_event *s = calloc(1, sizeof *s);
    if (!s) {
        ost_backend_close(backend);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    }
    s->scene = scene;
    s->backend = backend;
    ost_status status = ost_tool_upload(backend, &scene->event.tool, &s->tool, err);
    if (status == OST_OK)
        status = ost_bone_create(backend, &scene->event.bone, chunk_size, SCENE_THRESHOLD, &s->bone, err);
    for (int32_t z = 0; z < d.z && status == OST_OK; z += SLAB)
        status = ost_bone_upload(s->bone, z, d.z - z < SLAB ? d.z - z : SLAB,
                                 scene->voxels + (size_t)d.x * (size_t)d.y * (size_t)z, err);
    if (status == OST_OK)
        *state = s;
    else
        close_own(s);
    return status;
}

static ost_status open_cpu(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    const bench_options options = {.backend = setup->backend};
    ost_backend *backend = NULL;
    ost_status status = bench_backend(&options, setup->threads, &backend, err);
    return status == OST_OK ? open_on(backend, scene, setup->chunk_size, state, err) : status;
}

static ost_status open_cl(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
#ifdef HAVE_OPENCL
    ost_backend *backend = NULL;
    ost_status status = ost_backend_open(setup->device->cl.spec, &backend, err);
    return status == OST_OK ? open_on(backend, scene, setup->chunk_size, state, err) : status;
#else
    (void)scene;
    (void)setup;
    (void)state;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL is not built in");
#endif
}

static ost_status restore(void *state, ost_error *err)
{
    own_event *s = state;
    const ost_dims d = s->scene->event.bone.dims;
    const ost_voxel_box *box = &s->scene->region;
    ost_status status = OST_OK;
    if (method_box_count(box))
        status = ost_bone_upload(s->bone, box->lo[2], box->hi[2] - box->lo[2],
                                 s->scene->voxels + (size_t)d.x * (size_t)d.y * (size_t)box->lo[2], err);
    if (status == OST_OK)
        status = ost_bone_collide(s->bone, s->tool, &s->scene->event.event, &s->report, err);
    return status == OST_OK ? ost_backend_finish(s->backend, err) : status;
}

static ost_status remove_event(void *state, ost_error *err)
{
    own_event *s = state;
    ost_status status = ost_bone_remove(s->bone, s->tool, &s->scene->event.event, &s->report, err);
    return status == OST_OK ? ost_backend_finish(s->backend, err) : status;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    own_event *s = state;
    const ost_dims d = s->scene->event.bone.dims;
    const ost_voxel_box *b = &set->box;
    const size_t slice = (size_t)d.x * (size_t)d.y, width = (size_t)(b->hi[0] - b->lo[0]);
    if (method_box_count(b) == 0)
        return OST_OK;
    int16_t *voxels = malloc(slice * sizeof *voxels);
    ost_status status = voxels ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice");
    for (int32_t k = b->lo[2]; k < b->hi[2] && status == OST_OK; k++) {
        status = ost_bone_download(s->bone, k, 1, voxels, err);
        for (int32_t j = b->lo[1]; j < b->hi[1] && status == OST_OK; j++) {
            const size_t at = method_set_row(set, j, k), from = (size_t)d.x * (size_t)j + (size_t)b->lo[0];
            const int16_t *before = s->scene->voxels + slice * (size_t)k + from;
            for (size_t i = 0; i < width; i++)
                if (before[i] != 0 && voxels[from + i] == 0)
                    set->in[at + i] = 1;
        }
    }
    free(voxels);
    return status;
}

/* The memory for the tool is unknown, because backends do not report it. */
static void work(void *state, method_work *out)
{
    own_event *s = state;
    ost_bone_info info;
    *out = (method_work){0};
    if (ost_bone_info_get(s->bone, &info, NULL) != OST_OK)
        return;
    out->bone_bytes = info.chunk_bytes;
    out->index_bytes = info.resident_bytes - info.chunk_bytes;
}

const method method_osteon = {
    .info = {.name = "osteon", .title = "osteon's event", .source = "osteon, docs/spec/arithmetic.md, AR-REM",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 3, .per_tool_voxel = 8,
    .open = open_cpu, .close = close_own, .restore = restore, .remove = remove_event, .result = result, .work = work,
};

const method method_osteon_cl = {
    .info = {.name = "osteon-cl", .title = "osteon's event on the device",
             .source = "osteon, docs/spec/arithmetic.md, AR-REM",
             .definition = METHODS_BONE_TO_TOOL, .device = true},
    .per_bone_voxel = 3, .per_tool_voxel = 8,
    .open = open_cl, .close = close_own, .restore = restore, .remove = remove_event, .result = result, .work = work,
};
