/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A method with a dense bone and a dense tool (thesis, sections 3.2.1 and 3.2.3, bone-to-tool). Every bone voxel of the
 * intersection box is compared with the tool's grid. The bone is one buffer without chunks. An event processes only the
 * voxels in the box, whereas the chunk system processes complete chunks.
 */
#include "reproduction/methods/matrix_pair.h"

static ost_status remove_event(void *state, ost_error *err)
{
    matrix_pair *s = state;
    return matrix_pair_remove(s, &s->bone.scene->event.box, err);
}

static void work(void *state, method_work *out)
{
    const matrix_pair *s = state;
    *out = matrix_pair_work(s, (int64_t)method_box_count(&s->bone.scene->event.box));
}

const method method_dense_pair = {
    .info = {.name = "dense_pair",
             .title = "bone voxels of the box against the tool's grid, one buffer",
             .source = "thesis, 3.2.1 and 3.2.3: bone-to-tool, without chunks",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 2, .per_tool_voxel = 0.2,
    .native = true,
    .open = matrix_pair_open, .close = matrix_pair_close, .restore = matrix_pair_restore, .remove = remove_event,
    .result = matrix_pair_result, .work = work,
};
