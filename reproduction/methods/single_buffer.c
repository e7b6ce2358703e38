/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The single buffer of thesis section 2.2: one matrix of densities for the complete bone, whose positions follow
 * from the indices. Nothing divides the buffer into regions, so an event processes every voxel of the bone
 * (section 3.1.1: chunks bypass numerous unnecessary voxel checks).
 */
#include "reproduction/methods/matrix.h"

#include <stdlib.h>

typedef struct single_buffer {
    matrix_bone bone;
    matrix_tool tool;
    matrix_map map;
    int threads;
} single_buffer;

static void close_buffer(void *state)
{
    single_buffer *s = state;
    matrix_bone_free(&s->bone);
    matrix_tool_free(&s->tool);
    matrix_map_free(&s->map);
    free(s);
}

static ost_status open_buffer(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    single_buffer *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->threads = setup->threads;
    ost_status status = matrix_bone_init(&s->bone, scene, err);
    if (status == OST_OK)
        status = matrix_tool_init(&s->tool, &scene->event.tool, err);
    if (status == OST_OK)
        *state = s;
    else
        close_buffer(s);
    return status;
}

static ost_status restore(void *state, ost_error *err)
{
    single_buffer *s = state;
    (void)err;
    matrix_bone_restore(&s->bone);
    matrix_touch(s->tool.words, s->tool.count * sizeof *s->tool.words);
    return OST_OK;
}

static ost_status remove_event(void *state, ost_error *err)
{
    single_buffer *s = state;
    const bench_scene *event = &s->bone.scene->event;
    const ost_dims d = event->bone.dims;
    const ost_voxel_box all = {.hi = {d.x, d.y, d.z}};
    ost_status status = matrix_map_make(&s->map, &event->map, &all, err);
    if (status == OST_OK)
        matrix_remove_box(s->bone.voxels, d, &all, &s->map, &s->tool, s->threads);
    return status;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    (void)err;
    matrix_bone_result(&((const single_buffer *)state)->bone, set);
    return OST_OK;
}

static void work(void *state, method_work *out)
{
    const single_buffer *s = state;
    *out = (method_work){.visited = (int64_t)s->bone.count,
                         .bone_bytes = matrix_bone_bytes(&s->bone),
                         .tool_bytes = (int64_t)(s->tool.count * sizeof *s->tool.words)};
}

const method method_single_buffer = {
    .info = {.name = "single_buffer",
             .title = "all bone voxels against the tool's grid, one buffer",
             .source = "thesis, 2.2 and 3.1.1: one buffer that is not sparse",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 2, .per_tool_voxel = 0.2,
    .native = true,
    .open = open_buffer, .close = close_buffer, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
};
