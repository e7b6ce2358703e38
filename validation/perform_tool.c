/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the tools of a case. A tool's meshes are snapped by src/core, by the second implementation or by the backend,
   and then voxelized. */
#include "validation/perform_parts.h"

#include <string.h>

/* If the backend snaps meshes itself, replaces the snapped meshes of src/core with those of the backend. */
static ost_status snap_by_backend(performer *p, const scene_tool *t, ost_snapped_mesh meshes[2], bool *own, bool *made,
                                  ost_error *err)
{
    ost_snapped_mesh its[2] = {{.fraction_bits = 0}, {.fraction_bits = 0}};
    if (p->second || !p->backend->ops->snap || !t->raw[0].triangle_count)
        return OST_OK;
    ost_status status = p->backend->ops->snap(p->backend, &t->raw[0], &meshes[0].grid, &its[0], err);
    if (status == OST_OK && t->raw[1].triangle_count)
        status = p->backend->ops->snap(p->backend, &t->raw[1], &meshes[0].grid, &its[1], err);
    if (status == OST_ERR_UNAVAILABLE)
        return OST_OK;
    *made = *own = status == OST_OK;
    for (int k = 0; k < 2 && *made; k++)
        meshes[k] = its[k];
    steps_meshes_free(its, status != OST_OK);
    return status;
}

/* Records the geometry and the snapped meshes of a tool before it is voxelized. */
static ost_status record_snap(performer *p, int i, const ost_snapped_mesh meshes[2], bool made, ost_error *err)
{
    trace_begin(p->w, TRACE_SNAP, p->case_index, (uint32_t)i);
    if (made)
        trace_flags(p->w, TRACE_MADE);
    const ost_status status =
        steps_put_snap(p->w, p->second, p->s->tools[i].raw[0].triangle_count ? meshes : NULL, err);
    const ost_status written = perform_end_record(p, TRACE_SNAP, (uint32_t)i, err);
    return status != OST_OK ? status : written;
}

ost_status perform_tool(performer *p, int i, ost_error *err)
{
    const scene_tool *t = &p->s->tools[i];
    const int32_t lo[3] = {0, 0, 0};
    ost_voxelize_report r;
    ost_tool_volume volume = {0};
    ost_snapped_mesh meshes[2];
    bool own;
    bool made = false;
    ost_status status = steps_meshes_of(p->second, t, meshes, &own, err);
    if (status == OST_OK)
        status = snap_by_backend(p, t, meshes, &own, &made, err);
    if (status == OST_OK)
        status = record_snap(p, i, meshes, made, err);
    if (status == OST_OK)
        p->grids[i] = meshes[0].grid;
    if (status == OST_OK && !perform_is_of_steps(p->s))
        status = ost_voxelize(p->backend, &meshes[0], meshes[1].triangle_count ? &meshes[1] : NULL, t->rule, &r,
                              &p->tools[i], err);
    steps_meshes_free(meshes, own);
    if (status != OST_OK || perform_is_of_steps(p->s))
        return status;
    if (status == OST_OK)
        status = ost_tool_download(p->tools[i], &volume, err);
    if (status == OST_OK) {
        trace_begin(p->w, TRACE_TOOL, p->case_index, (uint32_t)i);
        trace_word(p->w, r.solid_voxels);
        trace_word(p->w, r.cutting_voxels);
        trace_word(p->w, r.leaking_rows);
        uint8_t *voxels = trace_block(p->w, lo, volume.geometry.dims, 1);
        if (voxels)
            memcpy(voxels, volume.voxels, (size_t)ost_dims_count(volume.geometry.dims));
        status = perform_end_record(p, TRACE_TOOL, (uint32_t)i, err);
    }
    if (status == OST_OK)
        status = perform_give_tool(p, i, &volume.geometry, err);
    ost_tool_volume_free(&volume);
    return status;
}
