/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/mirror.h"

#include <stdlib.h>

enum { UPDATE_BYTES = 1 << 18 };

ost_status ost_cl_mirror_make(cl_bone *bone, ost_error *err)
{
    cl_mirror *m = bone->mirror = calloc(1, sizeof *m);
    if (!m)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a copy of a bone");
    ost_status status =
        ost_chunk_grid_init(&m->grid, bone->base.geometry.dims, bone->base.chunk_size, bone->base.threshold, err);
    m->at_once = UPDATE_BYTES / (bone->chunk_voxels / 8);
    m->changed = malloc(bone->chunks * sizeof *m->changed);
    m->listed = calloc(bone->chunks, sizeof *m->listed);
    m->words = malloc(m->at_once * bone->chunk_voxels / 8);
    if (status == OST_OK && (!m->changed || !m->listed || !m->words))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a copy of a bone of %zu chunks", bone->chunks);
    if (status != OST_OK)
        ost_cl_mirror_free(bone);
    return status;
}

void ost_cl_mirror_free(cl_bone *bone)
{
    cl_mirror *m = bone->mirror;
    if (!m)
        return;
    ost_chunk_grid_free(&m->grid);
    free(m->changed);
    free(m->listed);
    free(m->words);
    free(m);
    bone->mirror = NULL;
}

int64_t ost_cl_mirror_bytes(const cl_bone *bone)
{
    if (!bone->mirror)
        return 0;
    const size_t table = bone->chunks * (sizeof(ost_chunk) + sizeof *bone->mirror->changed + sizeof(bool));
    int64_t chunks, voxels;
    ost_chunk_grid_count(&bone->mirror->grid, &chunks, &voxels);
    return chunks * (int64_t)ost_chunk_bytes(bone->base.chunk_size) + (int64_t)table +
           (int64_t)(bone->mirror->at_once * bone->chunk_voxels / 8);
}

void ost_cl_mirror_changed(cl_bone *bone, size_t chunk)
{
    cl_mirror *m = bone->mirror;
    if (!m || m->listed[chunk])
        return;
    m->listed[chunk] = true;
    m->changed[m->count++] = (int32_t)chunk;
}
