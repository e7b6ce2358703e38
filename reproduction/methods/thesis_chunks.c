/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' chunks (Algs. 2.9 and 2.10): all voxels of each non-empty chunk of the intersection box are mapped by a
 * float matrix and compared with the tool's grid. The loop in C is bench/baseline_removal.c, and the kernel
 * in OpenCL, which is enqueued once per chunk, is bench/thesis_cl.c. This file selects the chunks of a scene.
 */
#include <stdlib.h>
#include <string.h>

#include "bench/thesis_cl.h"
#include "reproduction/methods/device.h"

typedef struct chunks {
    const methods_scene *scene;
    bench_thesis thesis; /* zero-initialized if the event has no chunk */
    bench_cl *cl;        /* NULL if the loop in C is used */
    int threads;
} chunks;

static void close_chunks(void *state)
{
    chunks *s = state;
    bench_thesis_free(&s->thesis);
    bench_cl_close(s->cl);
    free(s);
}

/*
 * Copies a chunk from the scene. Voxels outside the bone are set to 0. Returns true if the chunk has an active voxel.
 */
static bool copy_chunk(int16_t *out, const methods_scene *scene, const int32_t corner[3], int32_t n)
{
    const ost_dims d = scene->event.bone.dims;
    bool any = false;
    for (int32_t k = corner[2]; k < corner[2] + n; k++)
        for (int32_t j = corner[1]; j < corner[1] + n; j++)
            for (int32_t i = corner[0]; i < corner[0] + n; i++) {
                const bool in = i < d.x && j < d.y && k < d.z;
                *out = in ? scene->voxels[i + d.x * (j + (int64_t)d.y * k)] : 0;
                any |= *out++ != 0;
            }
    return any;
}

/* Replaces the full bone of the benchmark's scene with the voxels of this scene, and removes empty chunks
   (Alg. 2.10). */
static void take_voxels(bench_thesis *t, const methods_scene *scene)
{
    const int32_t n = t->event.chunk_size;
    const size_t voxels = (size_t)n * (size_t)n * (size_t)n;
    int count = 0;
    for (int c = 0; c < t->event.chunk_count; c++) {
        int32_t corner[3];
        memcpy(corner, t->corners[c], sizeof corner);
        if (!copy_chunk(t->full + (size_t)count * voxels, scene, corner, n))
            continue;
        memcpy(t->corners[count++], corner, sizeof corner);
    }
    t->event.chunk_count = count;
    t->bytes = (size_t)count * voxels * sizeof *t->full;
    bench_thesis_restore(t);
}

static ost_status open_chunks(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    chunks *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->scene = scene;
    s->threads = setup->threads;
    ost_status status = OST_OK;
    if (methods_scene_active_chunks(scene, setup->chunk_size) > 0) {
        status = bench_thesis_init(&s->thesis, &scene->event, setup->chunk_size, err);
        if (status == OST_OK)
            take_voxels(&s->thesis, scene);
    }
    if (status == OST_OK)
        *state = s;
    else
        close_chunks(s);
    return status;
}

static ost_status restore(void *state, ost_error *err)
{
    chunks *s = state;
    (void)err;
    if (s->thesis.event.chunk_count == 0)
        return OST_OK;
    bench_thesis_restore(&s->thesis);
    bench_read_bytes((const uint8_t *)s->thesis.live, s->thesis.bytes, 1);
    return OST_OK;
}

static ost_status remove_event(void *state, ost_error *err)
{
    const chunks *s = state;
    (void)err;
    bench_thesis_remove(&s->thesis.event, s->threads);
    return OST_OK;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    const chunks *s = state;
    const int32_t n = s->thesis.event.chunk_size;
    const ost_voxel_box *b = &set->box;
    (void)err;
    for (int c = 0; c < s->thesis.event.chunk_count; c++) {
        const int32_t *corner = s->thesis.corners[c];
        const int16_t *live = s->thesis.chunks[c], *full = s->thesis.full + (live - s->thesis.live);
        for (int32_t v = 0; v < n * n * n; v++) {
            const int32_t i = corner[0] + v % n, j = corner[1] + v / n % n, k = corner[2] + v / n / n;
            if (full[v] != 0 && live[v] == 0 && i >= b->lo[0] && j >= b->lo[1] && k >= b->lo[2] && i < b->hi[0] &&
                j < b->hi[1] && k < b->hi[2])
                set->in[method_set_row(set, j, k) + (size_t)(i - b->lo[0])] = 1;
        }
    }
    return OST_OK;
}

static void work(void *state, method_work *out)
{
    const chunks *s = state;
    const int64_t tool = ost_dims_count(s->scene->event.tool.geometry.dims) * (int64_t)sizeof(int16_t);
    const int64_t n = s->thesis.event.chunk_size;
    /* The thesis' bone needs memory for all active chunks, not only for the chunks of the event. */
    *out = (method_work){.visited = s->thesis.event.chunk_count * n * n * n, .tool_bytes = tool};
    methods_scene_chunk_memory(s->scene, (int)n, &out->bone_bytes, &out->index_bytes);
}

const method method_thesis_chunks = {
    .info = {.name = "thesis_chunks", .title = "the thesis' chunks, float map, in C",
             .source = "thesis, Algs. 2.9 and 2.10, 3.2.1",
             .definition = METHODS_BONE_TO_TOOL_FLOAT},
    .per_bone_voxel = 4, .per_tool_voxel = 2,
    .native = true,
    .open = open_chunks, .close = close_chunks, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
};

#ifdef HAVE_OPENCL
static ost_status device_failed(const chunks *s, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL device '%.100s' failed in the thesis' event",
                    bench_cl_name(s->cl));
}

static ost_status open_cl(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    char reason[BENCH_TEXT] = "";
    chunks *s = NULL;
    ost_status status = open_chunks(scene, setup, state, err);
    if (status != OST_OK)
        return status;
    s = *state;
    s->cl = bench_cl_open(setup->device->cl.spec, reason);
    if (!s->cl)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "%s", reason);
    else if (s->thesis.event.chunk_count && !bench_cl_take(s->cl, &s->thesis))
        status = device_failed(s, err);
    if (status != OST_OK) {
        close_chunks(s);
        *state = NULL;
    }
    return status;
}

static ost_status restore_cl(void *state, ost_error *err)
{
    chunks *s = state;
    if (s->thesis.event.chunk_count == 0)
        return OST_OK;
    /* A blocking write may return before the data is on the device. The empty kernel waits for the data. */
    return bench_cl_restore(s->cl, &s->thesis) && bench_cl_launch(s->cl) ? OST_OK : device_failed(s, err);
}

static ost_status remove_cl(void *state, ost_error *err)
{
    chunks *s = state;
    if (s->thesis.event.chunk_count == 0 || bench_cl_remove(s->cl, &s->thesis))
        return OST_OK;
    return device_failed(s, err);
}

static ost_status result_cl(void *state, method_set *set, ost_error *err)
{
    chunks *s = state;
    if (s->thesis.event.chunk_count && !bench_cl_fetch(s->cl, &s->thesis))
        return device_failed(s, err);
    return result(state, set, err);
}
#endif

const method method_thesis_chunks_cl = {
    .info = {.name = "thesis_chunks-cl", .title = "the thesis' chunks, a launch per chunk, on the device",
             .source = "thesis, Algs. 2.9 and 2.10, 3.2.1",
             .definition = METHODS_BONE_TO_TOOL_FLOAT, .device = true},
    .native = true,
    .per_bone_voxel = 4, .per_tool_voxel = 2,
#ifdef HAVE_OPENCL
    .open = open_cl, .close = close_chunks, .restore = restore_cl, .remove = remove_cl, .result = result_cl,
    .work = work,
#endif
};
