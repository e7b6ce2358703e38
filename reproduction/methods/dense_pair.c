/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pair of a dense bone and a dense tool: every bone voxel of the intersection box is compared with the tool's
 * grid (thesis, sections 3.2.1 and 3.2.3, bone-to-tool), and the bone is one buffer without chunks. In contrast
 * to the chunk system, the event processes exactly the voxels of the box, and not complete chunks.
 */
#include "reproduction/methods/matrix.h"

#include <stdlib.h>

typedef struct dense_pair {
    matrix_bone bone;
    matrix_tool tool;
    matrix_map map;
    int threads;
} dense_pair;

static void close_pair(void *state)
{
    dense_pair *s = state;
    matrix_bone_free(&s->bone);
    matrix_tool_free(&s->tool);
    matrix_map_free(&s->map);
    free(s);
}

static ost_status open_pair(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    dense_pair *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->threads = setup->threads;
    ost_status status = matrix_bone_init(&s->bone, scene, err);
    if (status == OST_OK)
        status = matrix_tool_init(&s->tool, &scene->event.tool, err);
    if (status == OST_OK)
        *state = s;
    else
        close_pair(s);
    return status;
}

static ost_status restore(void *state, ost_error *err)
{
    dense_pair *s = state;
    (void)err;
    matrix_bone_restore(&s->bone);
    matrix_touch(s->tool.words, s->tool.count * sizeof *s->tool.words);
    return OST_OK;
}

static ost_status remove_event(void *state, ost_error *err)
{
    dense_pair *s = state;
    const bench_scene *event = &s->bone.scene->event;
    ost_status status = matrix_map_make(&s->map, &event->map, &event->box, err);
    if (status == OST_OK)
        matrix_remove_box(s->bone.voxels, event->bone.dims, &event->box, &s->map, &s->tool, s->threads);
    return status;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    (void)err;
    matrix_bone_result(&((const dense_pair *)state)->bone, set);
    return OST_OK;
}

static void work(void *state, method_work *out)
{
    const dense_pair *s = state;
    *out = (method_work){.visited = (int64_t)method_box_count(&s->bone.scene->event.box),
                         .bone_bytes = matrix_bone_bytes(&s->bone),
                         .tool_bytes = (int64_t)(s->tool.count * sizeof *s->tool.words)};
}

const method method_dense_pair = {
    .info = {.name = "dense_pair",
             .title = "bone voxels of the box against the tool's grid, one buffer",
             .source = "thesis, 3.2.1 and 3.2.3: bone-to-tool, without chunks",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 2, .per_tool_voxel = 0.2,
    .native = true,
    .open = open_pair, .close = close_pair, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
};
