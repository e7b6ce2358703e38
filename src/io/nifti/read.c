/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "io/nifti/read.h"

#ifdef HAVE_NIFTI

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "io/nifti/header.h"
#include "io/volume/rows.h"

enum { NAME_MAX_BYTES = 4096 };

/* The file that contains the voxels. */
typedef struct image {
    char path[NAME_MAX_BYTES];
    bool packed;
    uint64_t at;
} image;

static ost_status open_image(void *user, uint64_t index, ost_input **out, ost_error *err)
{
    const image *im = user;
    (void)index;
    ost_status status = ost_input_open(im->path, out, err);
    if (status == OST_OK && im->packed)
        status = ost_input_gunzip(*out, err);
    if (status == OST_OK)
        status = ost_input_skip(*out, im->at, err);
    if (status != OST_OK) {
        ost_input_close(*out);
        *out = NULL;
    }
    return status;
}

static bool ends_in(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n > m && strcasecmp(text + n - m, end) == 0;
}

/* Finds the image file of a pair: x.img or x.img.gz for the header x.hdr or x.hdr.gz. */
static ost_status find_image(const char *header, image *out, ost_error *err)
{
    size_t stem = strlen(header);
    if (ends_in(header, ".hdr.gz"))
        stem -= 7;
    else if (ends_in(header, ".hdr"))
        stem -= 4;
    else
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: the header of a pair (magic ni1 or ni2); expected a name that ends in .hdr", header);
    if (stem + sizeof ".img.gz" > sizeof out->path)
        return ost_fail(err, OST_ERR_INPUT, "%.60s...: the name is too long", header);
    snprintf(out->path, sizeof out->path, "%.*s.img", (int)stem, header);
    out->packed = access(out->path, F_OK) != 0;
    if (!out->packed)
        return OST_OK;
    snprintf(out->path, sizeof out->path, "%.*s.img.gz", (int)stem, header);
    if (access(out->path, F_OK) == 0)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "%s: no file with the voxels; expected %.*s.img or .img.gz in the same folder",
                    header, (int)stem, header);
}

static ost_status read_voxels(ost_input *input, const ost_nifti_header *header, const ost_volume_options *options,
                              const ost_placement *placement, const ost_geometry *geometry, const ost_target *target,
                              ost_volume_report *report, ost_error *err)
{
    image im;
    const char *path = ost_input_path(input);
    ost_status status = OST_OK;
    if (header->pair) {
        status = find_image(path, &im, err);
    } else if (strlen(path) < sizeof im.path) {
        strcpy(im.path, path);
        im.packed = ost_input_is_packed(input);
    } else {
        status = ost_fail(err, OST_ERR_INPUT, "%.60s...: the name is too long", path);
    }
    if (status != OST_OK)
        return status;
    im.at = header->image_at;
    snprintf(report->encoding, sizeof report->encoding, "%s", im.packed ? "gzip" : "raw");

    uint64_t voxels = (uint64_t)header->sizes[0] * (uint64_t)header->sizes[1] * (uint64_t)header->sizes[2];
    ost_parts parts = {
        .open = open_image, .user = &im, .count = 1, .part_bytes = voxels * ost_element_bytes(header->element)};
    ost_rows rows = {.next = ost_rows_next_binary, .path = path, .options = options, .parts = &parts};
    memcpy(rows.sizes, header->sizes, sizeof rows.sizes);
    rows.converter = (ost_converter){.element = header->element,
                                     .swap = header->swap,
                                     .clamp = options && options->clamp,
                                     .nan_as_air = options && options->nan_as_air,
                                     .scaled = header->scaled,
                                     .slope = header->slope,
                                     .intercept = header->intercept};
    status = ost_volume_fill(&rows, &header->affine, placement, geometry, target, err);
    ost_parts_close(&parts);
    report->rounded_values = rows.converter.rounded;
    report->clamped_values = rows.converter.clamped;
    report->nan_values = rows.converter.nan;
    return status;
}

ost_status ost_nifti_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                          ost_element *element, ost_error *err)
{
    ost_nifti_header header;
    ost_placement placement;
    const ost_nifti_form form = options ? options->form : OST_FORM_AUTO;
    ost_status status = ost_nifti_header_read(input, form, NULL, &header, err);
    if (status != OST_OK)
        return status;
    snprintf(report->type, sizeof report->type, "%s", ost_element_name(header.element));
    snprintf(report->encoding, sizeof report->encoding, "%s", ost_input_is_packed(input) ? "gzip" : "raw");
    report->labels = header.labels;
    *element = header.element;
    *meta = header.meta;
    status = ost_volume_orientation(ost_input_path(input), options, &header.affine, &header.oriented, meta, report,
                                    err);
    if (status != OST_OK)
        return status;
    status = ost_volume_resolve(ost_input_path(input), &header.affine, header.sizes, options, header.oriented,
                                &placement, geometry, report, err);
    if (status == OST_OK && target) {
        status = read_voxels(input, &header, options, &placement, geometry, target, report, err);
    }
    return status;
}

#else

ost_status ost_nifti_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                          ost_element *element, ost_error *err)
{
    (void)options, (void)target, (void)geometry, (void)meta, (void)report, (void)element;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: cannot read NIfTI: osteon was built without libnifti; install libnifti (Debian: "
                    "libnifti-dev) and build again", ost_input_path(input));
}

#endif
