/* SPDX-License-Identifier: Apache-2.0 */
/* Reads volumes. The format is determined by the content, not by the name. */
#include <osteon/io.h>

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/dicom/read.h"
#include "io/metaimage/header.h"
#include "io/metaimage/read.h"
#include "io/nifti/read.h"
#include "io/nrrd/read.h"
#include "io/stack/names.h"
#include "io/stack/read.h"
#include "io/stack/slice.h"
#include "io/volume/input.h"
#include "io/volume_read.h"

/*
 * Returns the path of the file to read. For the image file x.img of a NIfTI pair, this is the path of the header x.hdr,
 * which is written to `out`. For all other files, it is `path`.
 */
static const char *header_of(const char *path, char *out, size_t capacity)
{
    static const struct {
        const char *image, *header[2];
    } pairs[] = {{".img", {".hdr", ".hdr.gz"}}, {".img.gz", {".hdr.gz", ".hdr"}}};
    size_t n = strlen(path);
    for (size_t p = 0; p < 2; p++) {
        size_t m = strlen(pairs[p].image);
        if (n <= m || n + 8 > capacity || strcasecmp(path + n - m, pairs[p].image) != 0)
            continue;
        for (size_t h = 0; h < 2; h++) {
            snprintf(out, capacity, "%.*s%s", (int)(n - m), path, pairs[p].header[h]);
            if (access(out, F_OK) == 0)
                return out;
        }
    }
    return path;
}

static ost_status unknown(const char *path, const unsigned char *bytes, size_t size, ost_error *err)
{
    if (size == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: file is empty; expected an NRRD, NIfTI, MetaImage or DICOM volume",
                        path);
    if (ost_nifti_is_truncated(bytes, size))
        return ost_fail(err, OST_ERR_INPUT, "%s: truncated NIfTI header: %zu bytes; expected at least %d", path, size,
                        OST_NIFTI_SNIFF);
    char start[3 * 8 + 1] = "";
    for (size_t i = 0; i < size && i < 8; i++)
        snprintf(start + 3 * i, 4, "%02x ", bytes[i]);
    start[strlen(start) - 1] = 0;
    return ost_fail(err, OST_ERR_INPUT, "%s: not an NRRD, NIfTI, MetaImage or DICOM file (it starts with bytes %s)",
                    path, start);
}

/* Returns OST_ERR_USAGE if an option is set that applies only to DICOM. */
static ost_status check_not_dicom(const char *path, const ost_volume_options *options, ost_error *err)
{
    const char *name = !options             ? NULL
                       : options->series      ? "--series"
                       : options->even_slices ? "--even-slices"
                       : options->untilt      ? "--untilt"
                                              : NULL;
    return name ? ost_fail(err, OST_ERR_USAGE, "%s: is not DICOM; omit %s", path, name) : OST_OK;
}

static ost_status read_target(const char *path, const ost_volume_options *options, const ost_target *target,
                              ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                              ost_error *err)
{
    char pair[4096];
    unsigned char head[OST_NIFTI_SNIFF];
    size_t got;
    ost_input *input;
    memset(geometry, 0, sizeof *geometry);
    memset(meta, 0, sizeof *meta);
    memset(report, 0, sizeof *report);
    struct stat info;
    bool stack = false;
    const bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    ost_status status = folder || ost_stack_is_pattern(path) ? ost_stack_find(path, &stack, err) : OST_OK;
    if (status == OST_OK && stack && (status = check_not_dicom(path, options, err)) == OST_OK)
        return ost_stack_read(path, options, target, geometry, meta, report, element, err);
    if (status != OST_OK)
        return status;
    if (folder)
        return ost_dicom_read(path, options, target, geometry, meta, report, element, err);
    path = header_of(path, pair, sizeof pair);
    status = ost_input_open(path, &input, err);
    if (status != OST_OK)
        return status;
    status = ost_input_read(input, head, sizeof head, &got, err);
    if (status == OST_OK && ost_dicom_sniff(head, got)) {
        status = ost_dicom_read(path, options, target, geometry, meta, report, element, err);
        goto done;
    }
    if (status == OST_OK)
        status = check_not_dicom(path, options, err);
    if (status == OST_OK && ost_slice_sniff(head, got) != OST_SLICE_NONE) {
        ost_input_close(input);
        return ost_stack_read(path, options, target, geometry, meta, report, element, err);
    }
    if (status == OST_OK && got >= 4 && memcmp(head, "NRRD", 4) == 0) {
        status = ost_input_seek(input, 0, err);
        if (status == OST_OK)
            status = ost_nrrd_read(input, options, target, geometry, meta, report, element, err);
        goto done;
    }
    if (status == OST_OK && ost_metaimage_sniff(head, got)) {
        status = ost_input_seek(input, 0, err);
        if (status == OST_OK)
            status = ost_metaimage_read(input, options, target, geometry, meta, report, element, err);
        goto done;
    }
    if (status == OST_OK && got >= 2 && head[0] == 0x1f && head[1] == 0x8b) {
        status = ost_input_seek(input, 0, err);
        if (status == OST_OK)
            status = ost_input_gunzip(input, err);
        if (status == OST_OK)
            status = ost_input_read(input, head, sizeof head, &got, err);
        if (status == OST_OK && got >= 4 && memcmp(head, "NRRD", 4) == 0)
            status = ost_fail(err, OST_ERR_INPUT,
                              "%s: the complete NRRD file is compressed; decompress it with gzip -d first", path);
        else if (status == OST_OK && ost_nifti_sniff(head, got) == 0)
            status = ost_fail(err, OST_ERR_INPUT, "%s: gzip data, but not a NIfTI volume", path);
        if (status == OST_OK)
            status = ost_input_seek(input, 0, err);
        if (status == OST_OK)
            status = ost_input_gunzip(input, err);
    } else if (status == OST_OK) {
        if (ost_nifti_sniff(head, got) == 0)
            status = unknown(path, head, got, err);
        else
            status = ost_input_seek(input, 0, err);
    }
    if (status == OST_OK)
        status = ost_nifti_read(input, options, target, geometry, meta, report, element, err);
done:
    ost_input_close(input);
    return status;
}

ost_status ost_volume_read_any(const char *path, const ost_volume_options *options, const ost_target *target,
                               ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                               ost_error *err)
{
    if (target && target->volume)
        memset(target->volume, 0, sizeof *target->volume);
    ost_status status = read_target(path, options, target, geometry, meta, report, element, err);
    if (status == OST_OK && target && target->volume)
        target->volume->meta = *meta;
    return status;
}

ost_status ost_volume_read(const char *path, const ost_volume_options *options, ost_volume *out,
                           ost_volume_report *report, ost_error *err)
{
    ost_geometry geometry;
    ost_meta meta;
    ost_volume_report own;
    ost_element element;
    const ost_target target = {.volume = out};
    return ost_volume_read_any(path, options, &target, &geometry, &meta, report ? report : &own, &element, err);
}

ost_status ost_volume_read_header(const char *path, ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                                  ost_error *err)
{
    ost_geometry own_geometry;
    ost_meta own_meta;
    ost_volume_report own;
    ost_element element;
    return ost_volume_read_any(path, NULL, NULL, geometry ? geometry : &own_geometry, meta ? meta : &own_meta,
                               report ? report : &own, &element, err);
}
