/* SPDX-License-Identifier: Apache-2.0 */
/* Implements bones that store one density and one occupancy flag per voxel. Chunks are not stored; only their numbers
   are used (AR-CHK, AR-DIG-2). */
#include "validation/dense/parts.h"

#include <stdlib.h>
#include <string.h>

ost_status dense_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                             ost_bone **out, ost_error *err)
{
    const size_t count = (size_t)ost_dims_count(geometry->dims);
    dense_bone *bone = calloc(1, sizeof *bone);
    if (!bone)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone");
    bone->base = (ost_bone){
        .backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold};
    bone->density = calloc(count, sizeof *bone->density);
    bone->active = calloc(count, 1);
    if (!bone->density || !bone->active) {
        dense_bone_free(&bone->base);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %d x %d x %d voxels", geometry->dims.x,
                        geometry->dims.y, geometry->dims.z);
    }
    *out = &bone->base;
    return OST_OK;
}

void dense_bone_free(ost_bone *base)
{
    dense_bone *bone = (dense_bone *)base;
    free(bone->density);
    free(bone->active);
    free(bone);
}

static int32_t chunks_along(int32_t dim, int32_t n)
{
    return (dim + n - 1) / n;
}

static int64_t chunk_of(const ost_bone *bone, int32_t i, int32_t j, int32_t k)
{
    const int32_t n = bone->chunk_size;
    const ost_dims d = {chunks_along(bone->geometry.dims.x, n), chunks_along(bone->geometry.dims.y, n), 1};
    return dense_at(d, i / n, j / n, k / n);
}

/* Returns true if at least one voxel of chunk (a, b, c) is active. */
static bool has_active(const dense_bone *bone, int32_t a, int32_t b, int32_t c)
{
    const int32_t n = bone->base.chunk_size;
    const ost_dims d = bone->base.geometry.dims;
    for (int32_t k = c * n; k < (c + 1) * n && k < d.z; k++)
        for (int32_t j = b * n; j < (b + 1) * n && j < d.y; j++)
            for (int32_t i = a * n; i < (a + 1) * n && i < d.x; i++)
                if (bone->active[dense_at(d, i, j, k)])
                    return true;
    return false;
}

ost_status dense_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    (void)err;
    const dense_bone *bone = (const dense_bone *)base;
    const int32_t n = base->chunk_size;
    const ost_dims d = base->geometry.dims;
    const int64_t count = ost_dims_count(d);
    info->active_chunks = 0;
    info->active_voxels = 0;
    /* number of active voxels with density 0, which exist only with a deviation that does not clear the occupancy */
    int64_t emptied = 0;
    for (int64_t v = 0; v < count; v++) {
        info->active_voxels += bone->active[v];
        emptied += bone->active[v] && bone->density[v] == 0;
    }
    deviant *m = dense_of(base->backend)->deviant;
    if (emptied && m && m->how.kind == DEVIATION_OCCUPANCY_NOT_CLEARED)
        deviant_changed_report(m, -1);
    for (int32_t c = 0; c < chunks_along(d.z, n); c++)
        for (int32_t b = 0; b < chunks_along(d.y, n); b++)
            for (int32_t a = 0; a < chunks_along(d.x, n); a++)
                info->active_chunks += has_active(bone, a, b, c);
    info->chunk_bytes = info->active_chunks * (2 * (int64_t)n * n * n + (int64_t)n * n * n / 8);
    info->resident_bytes = count * 3 + (int64_t)sizeof *bone;
    return OST_OK;
}

/* ---------------------------------------------------------------- upload */

typedef struct upload {
    int32_t z0, count;
    const int16_t *voxels;
} upload;

/* Returns the density at (i, j, k) of the grid from the uploaded slices, or 0 outside of these slices. */
static int16_t given(const dense_bone *bone, const upload *from, int32_t i, int32_t j, int32_t k)
{
    const ost_dims d = bone->base.geometry.dims;
    if (i >= d.x || k < from->z0 || k >= from->z0 + from->count)
        return 0;
    return from->voxels[dense_at(d, i, j, k - from->z0)];
}

/* Stores a voxel by the rule of AR-CHK-1, or with the deliberate mistake of *m. */
static void store(deviant *m, const dense_bone *bone, const upload *from, int32_t i, int32_t j, int32_t k,
                  int16_t *density, uint8_t *active)
{
    const int32_t n = bone->base.chunk_size, threshold = bone->base.threshold;
    const ost_dims d = bone->base.geometry.dims;
    const uint64_t chunk = (uint64_t)chunk_of(&bone->base, i, j, k);
    int16_t v = given(bone, from, i, j, k);
    const bool right_active = v >= threshold;
    const int16_t right = right_active ? v : 0;
    bool fused;

    if (deviates(m, DEVIATION_CHUNK_SHIFTED, chunk))
        v = given(bone, from, i + 1, j, k);
    if (deviates(m, DEVIATION_BYTE_ORDER, chunk))
        v = (int16_t)(uint16_t)((uint16_t)v << 8 | (uint16_t)v >> 8);
    if (i % n == n - 1 && deviates(m, DEVIATION_CHUNK_BORDER_LOST, chunk))
        v = 0;
    if ((i >= d.x / n * n || j >= d.y / n * n || k >= d.z / n * n) && deviates(m, DEVIATION_PARTIAL_CHUNKS_LOST, 0))
        v = 0;
    bool is = v >= threshold;
    if (deviates(m, DEVIATION_WRONG_THRESHOLD, chunk))
        is = v > threshold;
    if (deviates(m, DEVIATION_UNSIGNED_COMPARE, chunk))
        is = (uint16_t)v >= threshold;
    *active = is;
    *density = is ? v : 0;
    if (deviates(m, DEVIATION_INACTIVE_KEPT, chunk) || deviant_thesis(m, &fused))
        *density = v;
    if (m && (*density != right || *active != right_active))
        deviant_acted(m, chunk, (const int32_t[3]){i, j, k});
}

/* Frees chunks without active voxels, as the thesis does. This sets densities below the threshold in these chunks to
   0. */
static void free_empty_chunks(deviant *m, dense_bone *bone)
{
    const int32_t n = bone->base.chunk_size;
    const ost_dims d = bone->base.geometry.dims;
    bool fused;
    if (!deviant_thesis(m, &fused))
        return;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t a = 0; a < chunks_along(d.x, n); a++)
                if (!has_active(bone, a, j / n, k / n))
                    for (int32_t i = a * n; i < (a + 1) * n && i < d.x; i++)
                        bone->density[dense_at(d, i, j, k)] = 0;
}

ost_status dense_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    (void)err;
    dense_bone *bone = (dense_bone *)base;
    deviant *m = dense_of(base->backend)->deviant;
    const upload from = {z0, count, voxels};
    const ost_dims d = base->geometry.dims;
    deviant_begin(m, DEVIATION_CHUNKS, d, base->chunk_size);
    for (int32_t k = z0; k < z0 + count; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++) {
                const int64_t at = dense_at(d, i, j, k);
                store(m, bone, &from, i, j, k, &bone->density[at], &bone->active[at]);
            }
    free_empty_chunks(m, bone);
    for (int32_t k = z0; deviant_in(m, DEVIATION_CHUNKS) && k < z0 + count; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++) {
                int16_t right;
                uint8_t active;
                store(NULL, bone, &from, i, j, k, &right, &active);
                if (bone->density[dense_at(d, i, j, k)] != right)
                    deviant_changed_voxel(m, (const int32_t[3]){i, j, k});
            }
    return OST_OK;
}

ost_status dense_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                 ost_error *err)
{
    const ost_status status = dense_bone_create(cubic->backend, &cubic->geometry, chunk_size, threshold, out, err);
    if (status != OST_OK)
        return status;
    return dense_bone_upload(*out, 0, cubic->geometry.dims.z, ((const dense_grid *)cubic)->made.voxels, err);
}

ost_status dense_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    const size_t slice = (size_t)bone->geometry.dims.x * (size_t)bone->geometry.dims.y;
    memcpy(voxels, ((const dense_bone *)bone)->density + (size_t)z0 * slice, (size_t)count * slice * sizeof *voxels);
    return OST_OK;
}

ost_status dense_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const dense_bone *bone = (const dense_bone *)base;
    const ost_dims d = base->geometry.dims;
    int16_t *leaf = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    ost_status status = leaf ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a leaf");
    for (int32_t c = 0; c < d.z && status == OST_OK; c += OST_LEAF)
        for (int32_t b = 0; b < d.y && status == OST_OK; b += OST_LEAF)
            for (int32_t a = 0; a < d.x && status == OST_OK; a += OST_LEAF) {
                int64_t v = 0;
                for (int32_t k = c; k < c + OST_LEAF; k++)
                    for (int32_t j = b; j < b + OST_LEAF; j++)
                        for (int32_t i = a; i < a + OST_LEAF; i++)
                            leaf[v++] = i < d.x && j < d.y && k < d.z ? bone->density[dense_at(d, i, j, k)] : 0;
                status = ost_digest_leaf16(leaf, leaves++, err);
            }
    free(leaf);
    return status;
}
