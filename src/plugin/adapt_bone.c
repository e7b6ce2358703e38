/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bones of a plugin.  The host computes the digests of leaves from downloaded slices, so
 * a plugin does not need SHA-256 and cannot report a false digest.
 */
#include "plugin/adapt.h"

#include <stdlib.h>
#include <string.h>

static ost_status new_bone(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                           plugin_bone **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone");
    (*out)->base = (ost_bone){
        .backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold};
    return OST_OK;
}

static ost_status made_bone(plugin_bone *bone, const char *slot, ost_status status, ost_bone **out, ost_error *err)
{
    if (status == OST_OK && !bone->own)
        status = ost_adapt_no_object(adapt_backend(bone->base.backend), slot, err);
    if (status != OST_OK) {
        free(bone);
        return status;
    }
    *out = &bone->base;
    return OST_OK;
}

ost_status ost_adapt_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                     ost_error *err)
{
    const plugin_grid *from = (const plugin_grid *)cubic;
    plugin_backend *b = adapt_backend(cubic->backend);
    plugin_bone *bone;
    plugin_error_sink t;
    ost_status status = from->lost ? ost_adapt_is_lost(b, err)
                                   : new_bone(cubic->backend, &cubic->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(
        b, "cubic_to_chunks",
        b->table.cubic_to_chunks(from->own, chunk_size, threshold, &bone->own, &adapt_listening(&t)->error), &t, NULL,
        err);
    return made_bone(bone, "cubic_to_chunks", status, out, err);
}

ost_status ost_adapt_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                                 ost_bone **out, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    const ost_plugin_geometry g = ost_adapt_geometry(geometry);
    plugin_bone *bone;
    plugin_error_sink t;
    ost_status status = new_bone(backend, geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    status = ost_adapt_heard(
        b, "bone_create",
        b->table.bone_create(b->self, &g, chunk_size, threshold, &bone->own, &adapt_listening(&t)->error), &t, NULL,
        err);
    return made_bone(bone, "bone_create", status, out, err);
}

void ost_adapt_bone_free(ost_bone *base)
{
    plugin_bone *bone = (plugin_bone *)base;
    adapt_table(base->backend)->bone_free(bone->own);
    free(bone);
}

ost_status ost_adapt_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    const plugin_bone *bone = (const plugin_bone *)base;
    plugin_backend *b = adapt_backend(base->backend);
    ost_plugin_bone_stats s = {.size = sizeof s};
    plugin_error_sink t;
    ost_status status = bone->lost ? ost_adapt_is_lost(b, err)
                                   : ost_adapt_heard(b, "bone_stats",
                                                     b->table.bone_stats(bone->own, &s, &adapt_listening(&t)->error),
                                                     &t, NULL, err);
    if (status == OST_OK && (s.active_chunks < 0 || s.active_chunks > info->chunks || s.active_voxels < 0 ||
                             s.active_voxels > ost_dims_count(info->geometry.dims)))
        status = ost_fail(err, OST_ERR_UNAVAILABLE,
                          "plugin %s: bone_stats: %lld active chunks with %lld active voxels; the bone has %lld chunks "
                          "and %lld voxels",
                          b->name, (long long)s.active_chunks, (long long)s.active_voxels, (long long)info->chunks,
                          (long long)ost_dims_count(info->geometry.dims));
    if (status != OST_OK)
        return status;
    info->active_chunks = s.active_chunks;
    info->active_voxels = s.active_voxels;
    info->chunk_bytes = s.chunk_bytes;
    info->resident_bytes = s.resident_bytes;
    return OST_OK;
}

ost_status ost_adapt_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    plugin_bone *bone = (plugin_bone *)base;
    plugin_backend *b = adapt_backend(base->backend);
    plugin_error_sink t;
    if (bone->lost)
        return ost_adapt_is_lost(b, err);
    return ost_adapt_heard(b, "bone_upload",
                           b->table.bone_upload(bone->own, z0, count, voxels, &adapt_listening(&t)->error), &t,
                           &bone->lost, err);
}

ost_status ost_adapt_bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    const plugin_bone *bone = (const plugin_bone *)base;
    plugin_backend *b = adapt_backend(base->backend);
    plugin_error_sink t;
    if (bone->lost)
        return ost_adapt_is_lost(b, err);
    return ost_adapt_heard(b, "bone_download",
                           b->table.bone_download(bone->own, z0, count, voxels, &adapt_listening(&t)->error), &t, NULL,
                           err);
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* Copies the leaf that begins at (x, y) from a slab whose first slice is the leaf's first slice. Sets the
   leaf's voxels outside the grid to 0. */
static void cut_leaf(const int16_t *slab, ost_dims d, int32_t depth, int32_t x, int32_t y,
                     int16_t leaf[OST_LEAF * OST_LEAF * OST_LEAF])
{
    const int32_t wide = least(OST_LEAF, d.x - x), high = least(OST_LEAF, d.y - y);
    memset(leaf, 0, OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    for (int32_t k = 0; k < depth; k++)
        for (int32_t j = 0; j < high; j++)
            memcpy(leaf + OST_LEAF * (j + OST_LEAF * k),
                   slab + (size_t)x + (size_t)d.x * ((size_t)(y + j) + (size_t)d.y * (size_t)k),
                   (size_t)wide * sizeof *leaf);
}

ost_status ost_adapt_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const ost_dims d = base->geometry.dims;
    const size_t bytes = (size_t)d.x * (size_t)d.y * OST_LEAF * sizeof(int16_t);
    int16_t *slab = malloc(bytes), *leaf = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    ost_status status = slab && leaf ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu bytes of slices",
                                                         bytes);
    for (int32_t z = 0; z < d.z && status == OST_OK; z += OST_LEAF) {
        const int32_t depth = least(OST_LEAF, d.z - z);
        status = ost_adapt_bone_download(base, z, depth, slab, err);
        for (int32_t y = 0; y < d.y && status == OST_OK; y += OST_LEAF)
            for (int32_t x = 0; x < d.x && status == OST_OK; x += OST_LEAF) {
                cut_leaf(slab, d, depth, x, y, leaf);
                status = ost_digest_leaf16(leaf, leaves++, err);
            }
    }
    free(leaf);
    free(slab);
    return status;
}
