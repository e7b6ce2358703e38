/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The single buffer of thesis section 2.2: the complete bone is one matrix of densities, and a voxel's position follows
 * from its index. The buffer is not divided into regions, so an event processes every voxel of the bone (section 3.1.1:
 * chunks bypass numerous unnecessary voxel checks).
 */
#include "reproduction/methods/matrix_pair.h"

static ost_status remove_event(void *state, ost_error *err)
{
    matrix_pair *s = state;
    const ost_dims d = s->bone.scene->event.bone.dims;
    const ost_voxel_box all = {.hi = {d.x, d.y, d.z}};
    return matrix_pair_remove(s, &all, err);
}

static void work(void *state, method_work *out)
{
    const matrix_pair *s = state;
    *out = matrix_pair_work(s, (int64_t)s->bone.count);
}

const method method_single_buffer = {
    .info = {.name = "single_buffer",
             .title = "all bone voxels against the tool's grid, one buffer",
             .source = "thesis, 2.2 and 3.1.1: one buffer that is not sparse",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 2, .per_tool_voxel = 0.2,
    .native = true,
    .open = matrix_pair_open, .close = matrix_pair_close, .restore = matrix_pair_restore, .remove = remove_event,
    .result = matrix_pair_result, .work = work,
};
