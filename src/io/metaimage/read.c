/* SPDX-License-Identifier: Apache-2.0 */
#include "io/metaimage/read.h"

#include <stdio.h>
#include <string.h>

#include "io/metaimage/header.h"
#include "io/volume/rows.h"

static ost_status read_voxels(const char *path, const ost_metaimage_header *header, uint64_t header_end,
                              const ost_volume_options *options, const ost_placement *placement,
                              const ost_geometry *geometry, const ost_target *target,
                              ost_volume_report *report, ost_error *err)
{
    ost_data_files files = {.path = path,
                            .names = header->names,
                            .form = header->form,
                            .element_bytes = ost_element_bytes(header->element),
                            .attached_at = header_end,
                            .byte_skip = header->byte_skip};
    memcpy(files.sizes, header->sizes, sizeof files.sizes);
    ost_parts parts;
    ost_status status = ost_data_files_open(&files, &parts, err);
    if (status != OST_OK)
        return status;
    ost_rows rows = {
        .next = ost_rows_next_binary,
        .path = path,
        .options = options,
        .parts = &parts,
        .converter = {.element = header->element,
                      .swap = header->swap,
                      .clamp = options && options->clamp,
                      .nan_as_air = options && options->nan_as_air}};
    memcpy(rows.sizes, header->sizes, sizeof rows.sizes);
    status = ost_volume_fill(&rows, &header->affine, placement, geometry, target, err);
    ost_parts_close(&parts);
    report->rounded_values = rows.converter.rounded;
    report->clamped_values = rows.converter.clamped;
    report->nan_values = rows.converter.nan;
    return status;
}

ost_status ost_metaimage_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                              ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                              ost_error *err)
{
    const char *path = ost_input_path(input);
    ost_metaimage_header header;
    ost_placement placement;
    if (options && options->form != OST_FORM_AUTO)
        return ost_fail(err, OST_ERR_USAGE, "%s: is a MetaImage file; --form needs a NIfTI file", path);
    ost_status status = ost_metaimage_header_read(input, &header, err);
    const uint64_t header_end = ost_input_offset(input);
    if (status == OST_OK) {
        snprintf(report->type, sizeof report->type, "%s", ost_element_name(header.element));
        snprintf(report->encoding, sizeof report->encoding, "%s", header.form == OST_DATA_ZLIB ? "zlib" : "raw");
        *element = header.element;
        *meta = header.meta;
        status = ost_volume_orientation(path, options, &header.affine, &header.oriented, meta, report, err);
    }
    if (status == OST_OK)
        status = ost_volume_resolve(path, &header.affine, header.sizes, options, header.oriented, &placement, geometry,
                                    report, err);
    if (status == OST_OK && target) {
        status = read_voxels(path, &header, header_end, options, &placement, geometry, target, report, err);
    }
    ost_metaimage_header_free(&header);
    return status;
}
