/* SPDX-License-Identifier: Apache-2.0 */
/* The list of methods, and the function that opens a method if this machine can run it. */
#include "reproduction/methods/device.h"

static const method *const list[] = {
    &method_osteon,        &method_thesis_chunks, &method_dense_pair, &method_single_buffer, &method_sparse_buffer,
    &method_octree,        &method_yau,           &method_zheng,      &method_reza,          &method_osteon_cl,
    &method_thesis_chunks_cl, &method_texture_cl, &method_yau_cl,     &method_zheng_cl,      &method_reza_cl,
};

int methods_count(void)
{
    return (int)(sizeof list / sizeof list[0]);
}

const methods_info *methods_info_get(int index)
{
    return &list[index]->info;
}

const method *method_get(int index)
{
    return list[index];
}

double method_needs(const method *m, const methods_scene *scene)
{
    return m->per_bone_voxel * (double)ost_dims_count(scene->event.bone.dims) +
           m->per_tool_voxel * (double)ost_dims_count(scene->event.tool.geometry.dims);
}

ost_status method_open(const method *m, const methods_scene *scene, const method_setup *setup, void **state,
                       ost_error *err)
{
    char reason[BENCH_TEXT] = "";
    *state = NULL;
    if (m->native && !bench_baseline_runs(reason, sizeof reason))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", reason);
    if (m->info.device && (!m->open || !setup->device))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "no OpenCL device is open");
    if (method_needs(m, scene) > (double)bench_memory())
        return ost_fail(err, OST_ERR_MEMORY, "the method needs up to %.1f GB; less is free here",
                        method_needs(m, scene) * 1e-9);
    return m->open(scene, setup, state, err);
}
