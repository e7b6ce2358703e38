/* SPDX-License-Identifier: Apache-2.0 */
/* Runs each stage separately: after each stage, the reference's result replaces the backend's result and becomes the
   input of the next stage. */
#include "validation/perform_parts.h"

#include <stdlib.h>
#include <string.h>

static ost_status given_record(const performer *p, trace_stage stage, uint32_t item, const trace_record **out,
                               ost_error *err)
{
    for (size_t i = 0; i < p->in_given.count; i++) {
        *out = &p->given->records[p->in_given.first + i];
        if ((*out)->stage == stage && (*out)->item == item)
            return OST_OK;
    }
    return ost_fail(err, OST_ERR_INPUT, "the reference made no %s %u that could be given to the next stage",
                    trace_stage_name(stage), (unsigned)item);
}

/* Finds the complete grid of a stage in the reference's trace. */
static ost_status given_grid(const performer *p, trace_stage stage, uint32_t item, uint32_t voxel_bytes, ost_dims dims,
                             trace_block_view *out, ost_error *err)
{
    const trace_record *r;
    size_t at = 0;
    ost_status status = given_record(p, stage, item, &r, err);
    if (status == OST_OK && (!trace_next_block(r, &at, out) || out->voxel_bytes != voxel_bytes ||
                             out->dims.x != dims.x || out->dims.y != dims.y || out->dims.z != dims.z))
        status = ost_fail(err, OST_ERR_INPUT, "the reference's %s has not the size of this backend's",
                          trace_stage_name(stage));
    return status;
}

ost_status perform_give_grid(const performer *p, trace_stage stage, ost_grid *grid, ost_error *err)
{
    const ost_dims dims = ost_grid_geometry(grid)->dims;
    trace_block_view block;
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, stage, 0, sizeof(int16_t), dims, &block, err);
    if (status != OST_OK)
        return status;
    const size_t bytes = (size_t)ost_dims_count(dims) * sizeof(int16_t);
    int16_t *voxels = malloc(bytes); /* a copy, because the voxels of a trace need not be aligned */
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %zu bytes", bytes);
    memcpy(voxels, block.voxels, bytes);
    status = ost_grid_upload(grid, 0, dims.z, voxels, err);
    free(voxels);
    return status;
}

ost_status perform_give_bone(performer *p, ost_error *err)
{
    trace_block_view block;
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, TRACE_CHUNKS, 0, sizeof(int16_t), p->dims, &block, err);
    if (status != OST_OK)
        return status;
    const size_t bytes = (size_t)ost_dims_count(p->dims) * sizeof(int16_t);
    p->right = malloc(bytes);
    if (!p->right)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
    memcpy(p->right, block.voxels, bytes);
    memcpy(p->was, p->right, bytes);
    return ost_bone_upload(p->bone, 0, p->dims.z, p->right, err);
}

ost_status perform_give_tool(performer *p, int i, const ost_tool_geometry *geometry, ost_error *err)
{
    trace_block_view block;
    ost_tool_volume volume = {0};
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, TRACE_TOOL, (uint32_t)i, 1, geometry->dims, &block, err);
    if (status == OST_OK)
        status = ost_tool_volume_init(&volume, geometry, err);
    if (status == OST_OK) {
        memcpy(volume.voxels, block.voxels, (size_t)ost_dims_count(geometry->dims));
        ost_tool_free(p->tools[i]);
        p->tools[i] = NULL;
        status = ost_tool_upload(p->backend, &volume, &p->tools[i], err);
    }
    ost_tool_volume_free(&volume);
    return status;
}

ost_status perform_give_tick(performer *p, uint32_t i, int32_t z0, int32_t z1, ost_error *err)
{
    const ost_dims d = p->dims;
    const trace_record *r;
    trace_block_view block;
    size_t at = 0;
    if (!p->given)
        return OST_OK;
    const ost_status status = given_record(p, TRACE_TICK, i, &r, err);
    if (status != OST_OK)
        return status;
    while (trace_next_block(r, &at, &block)) {
        const ost_dims n = block.dims;
        if (block.voxel_bytes != sizeof(int16_t) || block.lo[0] < 0 || block.lo[1] < 0 || block.lo[2] < 0 ||
            block.lo[0] + n.x > d.x || block.lo[1] + n.y > d.y || block.lo[2] + n.z > d.z)
            return ost_fail(err, OST_ERR_INPUT, "a leaf of the reference's tick %u lies outside of the bone",
                            (unsigned)i);
        for (int32_t k = 0; k < n.z; k++)
            for (int32_t j = 0; j < n.y; j++)
                memcpy(p->right + perform_at(d, block.lo[0], block.lo[1] + j, block.lo[2] + k),
                       block.voxels + sizeof(int16_t) * (size_t)n.x * ((size_t)j + (size_t)n.y * (size_t)k),
                       sizeof(int16_t) * (size_t)n.x);
    }
    if (z0 >= z1)
        return OST_OK;
    const size_t from = perform_at(d, 0, 0, z0), bytes = sizeof(int16_t) * (perform_at(d, 0, 0, z1) - from);
    if (memcmp(p->was + from, p->right + from, bytes) == 0)
        return OST_OK;
    memcpy(p->was + from, p->right + from, bytes);
    return ost_bone_upload(p->bone, z0, z1 - z0, p->right + from, err);
}
