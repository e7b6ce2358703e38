/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bone of the reference: a chunk grid with a geometry (thesis, Alg. 2.6; AR-CHK).
 * core/chunk_grid.h documents the content of a chunk, and why results depend neither on
 * the chunk size nor on which chunks have memory.
 */
#include "cpu/ref/ref.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

ost_status ost_ref_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                               ost_bone **out, ost_error *err)
{
    ref_bone *bone = malloc(sizeof *bone);
    if (!bone)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone");
    bone->base = (ost_bone){
        .backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold};
    ost_status status = ost_chunk_grid_init(&bone->chunks, geometry->dims, chunk_size, threshold, err);
    if (status != OST_OK) {
        free(bone);
        return status;
    }
    *out = &bone->base;
    return OST_OK;
}

void ost_ref_bone_free(ost_bone *base)
{
    ref_bone *bone = (ref_bone *)base;
    ost_chunk_grid_free(&bone->chunks);
    free(bone);
}

ost_status ost_ref_cubic_to_chunks(const ost_grid *base, int chunk_size, int32_t threshold, ost_bone **out,
                                   ost_error *err)
{
    const ref_grid *cubic = (const ref_grid *)base;
    ost_bone *bone;
    ost_status status = ost_ref_bone_create(base->backend, &base->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    status = ost_ref_bone_upload(bone, 0, base->geometry.dims.z, cubic->voxels, err);
    if (status != OST_OK) {
        ost_ref_bone_free(bone);
        return status;
    }
    *out = bone;
    return OST_OK;
}

ost_status ost_ref_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    (void)err;
    const ref_bone *bone = (const ref_bone *)base;
    ost_chunk_grid_count(&bone->chunks, &info->active_chunks, &info->active_voxels);
    info->chunk_bytes = info->active_chunks * (int64_t)ost_chunk_bytes(base->chunk_size);
    info->resident_bytes = info->chunk_bytes + bone->chunks.count * (int64_t)sizeof *bone->chunks.chunks +
                           (int64_t)sizeof *bone;
    return OST_OK;
}

ost_status ost_ref_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    return ost_chunk_grid_upload(&((ref_bone *)base)->chunks, z0, count, voxels, err);
}

ost_status ost_ref_bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    ost_chunk_grid_download(&((const ref_bone *)base)->chunks, z0, count, voxels);
    return OST_OK;
}

ost_status ost_ref_bone_sample(const ost_bone *base, size_t count, const int32_t *const at[3], int16_t *densities,
                               ost_error *err)
{
    (void)err;
    ost_chunk_grid_sample(&((const ref_bone *)base)->chunks, count, at, densities);
    return OST_OK;
}

ost_status ost_ref_bone_occupancy(const ost_bone *base, size_t count, const int32_t *chunks, uint32_t *words,
                                  ost_error *err)
{
    (void)err;
    const ost_chunk_grid *grid = &((const ref_bone *)base)->chunks;
    const size_t size = (size_t)grid->size * (size_t)grid->size * (size_t)grid->size / 32;
    for (size_t i = 0; i < count; i++, words += size) {
        const ost_chunk *chunk = &grid->chunks[chunks[i]];
        if (chunk->density)
            memcpy(words, chunk->occupancy, size * sizeof *words);
        else
            memset(words, 0, size * sizeof *words);
    }
    return OST_OK;
}

ost_status ost_ref_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const ref_bone *bone = (const ref_bone *)base;
    ost_dims dims = ost_leaf_dims(base->geometry.dims);
    int16_t *voxels = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a leaf");
    ost_status status = OST_OK;
    for (int32_t z = 0; z < dims.z && status == OST_OK; z++)
        for (int32_t y = 0; y < dims.y && status == OST_OK; y++)
            for (int32_t x = 0; x < dims.x && status == OST_OK; x++, leaves++) {
                if (ost_chunk_grid_leaf(&bone->chunks, (ost_dims){x, y, z}, voxels))
                    status = ost_digest_leaf16(voxels, leaves, err);
                else
                    *leaves = ((const ref_backend *)base->backend)->empty_leaf;
            }
    free(voxels);
    return status;
}
