/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume_write.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "io/metaimage/write.h"
#include "io/nifti/write.h"
#include "io/nrrd/segments.h"
#include "io/nrrd/write.h"
#include "io/text/write.h"

static bool ends_in(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcasecmp(text + n - m, end) == 0;
}

ost_volume_format ost_volume_format_of(const char *path)
{
    return ends_in(path, ".nrrd")     ? OST_FORMAT_NRRD
           : ends_in(path, ".nii")    ? OST_FORMAT_NIFTI
           : ends_in(path, ".nii.gz") ? OST_FORMAT_NIFTI_GZIP
           : ends_in(path, ".mha")    ? OST_FORMAT_METAIMAGE
           : ends_in(path, ".txt")    ? OST_FORMAT_TEXT
                                      : OST_FORMAT_UNKNOWN;
}

ost_status ost_volume_format_unknown(const char *path, ost_error *err)
{
    return ost_fail(err, OST_ERR_USAGE,
                    "%s: unknown output format; expected a name that ends in .nrrd, .nii, .nii.gz, .mha or .txt", path);
}

ost_status ost_volume_writer_open(const char *path, const ost_geometry *geometry, const ost_meta *meta,
                                  const char *fields, ost_element element, bool odd_voxel,
                                  const ost_write_options *options, ost_volume_writer **out, ost_error *err)
{
    *out = NULL;
    ost_volume_format format = ost_volume_format_of(path);
    if (format == OST_FORMAT_UNKNOWN)
        return ost_volume_format_unknown(path, err);
    assert(format != OST_FORMAT_TEXT);
    assert(element == OST_ELEMENT_INT16 || (element == OST_ELEMENT_UINT8 && format == OST_FORMAT_NRRD));
    ost_volume_writer *w;
    ost_status status = ost_volume_writer_start(path, element, ost_dims_count(geometry->dims), options, &w, err);
    if (status != OST_OK)
        return status;
    const bool compress = options && options->compress;
    status = format == OST_FORMAT_NRRD
                 ? ost_nrrd_write_header(w, geometry, meta, fields, element, odd_voxel, compress, err)
             : format == OST_FORMAT_METAIMAGE
                 ? ost_metaimage_write_header(w, geometry, meta, err)
                 : ost_nifti_write_header(w, geometry, meta, format == OST_FORMAT_NIFTI_GZIP, err);
    if (status != OST_OK) {
        ost_volume_writer_discard(w);
        return status;
    }
    *out = w;
    return OST_OK;
}

ost_status ost_volume_write(const char *path, const ost_volume *volume, const ost_write_options *options,
                            ost_error *err)
{
    ost_volume_format format = ost_volume_format_of(path);
    if (format == OST_FORMAT_UNKNOWN)
        return ost_volume_format_unknown(path, err);
    ost_status status = ost_geometry_check(&volume->geometry, path, err);
    if (status != OST_OK)
        return status;
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "%s: the volume to write has no voxels", path);
    if (format == OST_FORMAT_TEXT)
        return ost_text_write_volume(path, volume, options, err);
    ost_volume_writer *w;
    const char *kind = ost_meta_get(&volume->meta, OST_META_KIND);
    char *segments = NULL;
    if (format == OST_FORMAT_NRRD && kind && strcmp(kind, "labels") == 0 && !(segments = ost_nrrd_segments(volume)))
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the names of its labels", path);
    status = ost_volume_writer_open(path, &volume->geometry, &volume->meta, segments, OST_ELEMENT_INT16, false, options,
                                    &w, err);
    free(segments);
    if (status != OST_OK)
        return status;
    status = ost_volume_writer_put(w, volume->voxels, (size_t)ost_dims_count(volume->geometry.dims), err);
    if (status == OST_OK)
        return ost_volume_writer_commit(w, err);
    ost_volume_writer_discard(w);
    return status;
}
