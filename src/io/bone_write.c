/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a bone to a file. The bone's cubic grid is downloaded in slabs of about SLAB_BYTES. */
#include <osteon/io.h>

#include <stdio.h>
#include <stdlib.h>

#include "io/text/write.h"
#include "io/volume_write.h"

enum { SLAB_BYTES = 8 << 20 };

static ost_status bone_meta(const ost_bone_info *info, const ost_meta *given, ost_meta *out, ost_error *err)
{
    char threshold[16], arithmetic[16];
    *out = given ? *given : (ost_meta){0};
    snprintf(threshold, sizeof threshold, "%d", info->threshold);
    snprintf(arithmetic, sizeof arithmetic, "%d", OST_ARITHMETIC_VERSION);
    ost_status status = ost_meta_set(out, OST_META_KIND, "bone", err);
    if (status == OST_OK)
        status = ost_meta_set(out, OST_META_THRESHOLD, threshold, err);
    if (status == OST_OK)
        status = ost_meta_set(out, OST_META_ARITHMETIC, arithmetic, err);
    return status;
}

/* Downloads the complete volume first, because the text writer needs it in one piece. */
static ost_status write_text(const char *path, const ost_bone *bone, const ost_bone_info *info, const ost_meta *meta,
                             const ost_write_options *options, ost_error *err)
{
    ost_volume volume;
    ost_status status = ost_volume_init(&volume, &info->geometry, err);
    if (status == OST_OK)
        status = ost_bone_download(bone, 0, info->geometry.dims.z, volume.voxels, err);
    volume.meta = *meta;
    if (status == OST_OK)
        status = ost_text_write_volume(path, &volume, options, err);
    ost_volume_free(&volume);
    return status;
}

static ost_status write_slabs(const char *path, const ost_bone *bone, const ost_bone_info *info, const ost_meta *meta,
                              const ost_write_options *options, ost_error *err)
{
    const ost_dims dims = info->geometry.dims;
    size_t slice = (size_t)dims.x * (size_t)dims.y;
    int32_t slices = (int32_t)(SLAB_BYTES / (slice * sizeof(int16_t)));
    slices = slices < 1 ? 1 : slices > dims.z ? dims.z : slices;
    ost_volume_writer *writer = NULL;
    int16_t *slab = malloc(slice * (size_t)slices * sizeof *slab);
    ost_status status = slab ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %d slices of %zu voxels",
                                                 path, slices, slice);
    if (status == OST_OK)
        status = ost_volume_writer_open(path, &info->geometry, meta, NULL, OST_ELEMENT_INT16, false, options, &writer,
                                        err);
    for (int32_t z = 0; status == OST_OK && z < dims.z; z += slices) {
        int32_t count = dims.z - z < slices ? dims.z - z : slices;
        status = ost_bone_download(bone, z, count, slab, err);
        if (status == OST_OK)
            status = ost_volume_writer_put(writer, slab, slice * (size_t)count, err);
    }
    free(slab);
    if (status == OST_OK)
        return ost_volume_writer_commit(writer, err);
    ost_volume_writer_discard(writer);
    return status;
}

ost_status ost_bone_write(const char *path, const ost_bone *bone, const ost_meta *meta,
                          const ost_write_options *options, ost_error *err)
{
    ost_bone_info info;
    ost_meta own;
    ost_volume_format format = ost_volume_format_of(path);
    if (format == OST_FORMAT_UNKNOWN)
        return ost_volume_format_unknown(path, err);
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = bone_meta(&info, meta, &own, err);
    if (status != OST_OK)
        return status;
    return format == OST_FORMAT_TEXT ? write_text(path, bone, &info, &own, options, err)
                                     : write_slabs(path, bone, &info, &own, options, err);
}
