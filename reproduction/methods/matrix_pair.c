/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/methods/matrix_pair.h"

#include <stdlib.h>

void matrix_pair_close(void *state)
{
    matrix_pair *s = state;
    matrix_bone_free(&s->bone);
    matrix_tool_free(&s->tool);
    matrix_map_free(&s->map);
    free(s);
}

ost_status matrix_pair_open(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    matrix_pair *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->threads = setup->threads;
    ost_status status = matrix_bone_init(&s->bone, scene, err);
    if (status == OST_OK)
        status = matrix_tool_init(&s->tool, &scene->event.tool, err);
    if (status == OST_OK)
        *state = s;
    else
        matrix_pair_close(s);
    return status;
}

ost_status matrix_pair_restore(void *state, ost_error *err)
{
    matrix_pair *s = state;
    (void)err;
    matrix_bone_restore(&s->bone);
    matrix_touch(s->tool.words, s->tool.count * sizeof *s->tool.words);
    return OST_OK;
}

ost_status matrix_pair_result(void *state, method_set *set, ost_error *err)
{
    (void)err;
    matrix_bone_result(&((const matrix_pair *)state)->bone, set);
    return OST_OK;
}

ost_status matrix_pair_remove(matrix_pair *pair, const ost_voxel_box *box, ost_error *err)
{
    const bench_scene *event = &pair->bone.scene->event;
    ost_status status = matrix_map_make(&pair->map, &event->map, box, err);
    if (status == OST_OK)
        matrix_remove_box(pair->bone.voxels, event->bone.dims, box, &pair->map, &pair->tool, pair->threads);
    return status;
}

method_work matrix_pair_work(const matrix_pair *pair, int64_t visited)
{
    return (method_work){.visited = visited,
                         .bone_bytes = matrix_bone_bytes(&pair->bone),
                         .tool_bytes = (int64_t)(pair->tool.count * sizeof *pair->tool.words)};
}
