/* SPDX-License-Identifier: Apache-2.0 */
/* Reads single voxels of a bone from the mirror, which is a copy of the voxels in host memory. */
#include "cl/mirror.h"

#include <stdlib.h>

enum { DOWNLOAD_BYTES = 1 << 24 };

/* Downloads all voxels of a bone to a chunk grid, several layers of chunks at a time. */
static ost_status download(const cl_bone *bone, ost_chunk_grid *grid, ost_error *err)
{
    const ost_dims d = bone->base.geometry.dims;
    const size_t slice = (size_t)d.x * (size_t)d.y, layer = slice * (size_t)grid->size * sizeof(int16_t);
    const int32_t layers = layer < DOWNLOAD_BYTES ? (int32_t)(DOWNLOAD_BYTES / layer) : 1;
    /* for small slices, this may exceed the number of slices of the bone */
    const int64_t most = (int64_t)layers * grid->size;
    const int32_t step = most < d.z ? (int32_t)most : d.z;
    int16_t *voxels = malloc(slice * (size_t)step * sizeof *voxels);
    ost_status status = voxels ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for the slices of a bone");
    for (int32_t z = 0; z < d.z && status == OST_OK; z += step) {
        const int32_t count = d.z - z < step ? d.z - z : step;
        status = ost_cl_bone_download(&bone->base, z, count, voxels, err);
        if (status == OST_OK)
            status = ost_chunk_grid_upload(grid, z, count, voxels, err);
    }
    free(voxels);
    return status;
}

/* Removes those voxels from the mirror that events have removed since the last update. If this fails, the list still
   contains the chunks that were not updated. */
static ost_status update(cl_bone *bone, ost_error *err)
{
    cl_mirror *m = bone->mirror;
    const size_t words = bone->chunk_voxels / 32;
    ost_status status = OST_OK;
    while (m->count && status == OST_OK) {
        const size_t some = m->count < m->at_once ? m->count : m->at_once, first = m->count - some;
        status = ost_cl_bone_occupancy(&bone->base, some, m->changed + first, m->words, err);
        if (status != OST_OK)
            break;
        for (size_t i = 0; i < some; i++) {
            const int32_t chunk = m->changed[first + i];
            ost_chunk_keep(&m->grid, &m->grid.chunks[chunk], m->words + i * words);
            m->listed[chunk] = false;
        }
        m->count = first;
    }
    return status;
}

/* The function casts away const, because it makes and updates the mirror. No voxel of the bone changes. */
ost_status ost_cl_bone_sample(const ost_bone *base, size_t count, const int32_t *const at[3], int16_t *densities,
                              ost_error *err)
{
    cl_bone *bone = (cl_bone *)(uintptr_t)base;
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status == OST_OK && !bone->mirror) {
        ((cl_backend *)base->backend)->entered[OST_CL_PATH_MIRROR_MADE]++;
        status = ost_cl_mirror_make(bone, err);
        if (status == OST_OK) {
            status = download(bone, &bone->mirror->grid, err);
            if (status != OST_OK)
                ost_cl_mirror_free(bone);
        }
    }
    if (status == OST_OK && bone->mirror->count) {
        ((cl_backend *)base->backend)->entered[OST_CL_PATH_MIRROR_UPDATED]++;
        status = update(bone, err);
    }
    if (status == OST_OK)
        ost_chunk_grid_sample(&bone->mirror->grid, count, at, densities);
    return status;
}
