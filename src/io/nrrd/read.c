/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nrrd/read.h"

#include <stdio.h>
#include <string.h>

#include "io/nrrd/header.h"
#include "io/nrrd/text_rows.h"
#include "io/volume/rows.h"

static const char *const encoding_names[] = {
    [OST_DATA_RAW] = "raw", [OST_DATA_GZIP] = "gzip", [OST_DATA_ZLIB] = "zlib", [OST_DATA_TEXT] = "text"};

static ost_status read_voxels(const char *path, const ost_nrrd_text *text, const ost_nrrd_header *header,
                              uint64_t header_end, const ost_volume_options *options, const ost_placement *placement,
                              const ost_geometry *geometry, const ost_target *target,
                              ost_volume_report *report, ost_error *err)
{
    ost_data_files files = {.path = path,
                            .names = {text->field[OST_NRRD_DATA_FILE].value, text->field[OST_NRRD_DATA_FILE].line,
                                      text->list, text->list_bytes},
                            .form = header->encoding,
                            .element_bytes = ost_element_bytes(header->element),
                            .attached_at = header_end,
                            .line_skip = header->line_skip,
                            .byte_skip = header->byte_skip};
    memcpy(files.sizes, header->sizes, sizeof files.sizes);
    ost_parts parts;
    ost_status status = ost_data_files_open(&files, &parts, err);
    if (status != OST_OK)
        return status;
    ost_nrrd_text_rows all = {
        .rows = {.next = parts.text ? ost_nrrd_text_rows_next : ost_rows_next_binary,
                 .path = path,
                 .options = options,
                 .parts = &parts}};
    memcpy(all.rows.sizes, header->sizes, sizeof all.rows.sizes);
    all.in_part = (uint64_t)header->sizes[0] * (uint64_t)header->sizes[1] * (uint64_t)header->sizes[2] / parts.count;
    all.rows.converter = (ost_converter){
        .element = header->element,
        .swap = header->swap,
        .clamp = options && options->clamp,
        .nan_as_air = options && options->nan_as_air};
    status = ost_volume_fill(&all.rows, &header->affine, placement, geometry, target, err);
    ost_parts_close(&parts);
    report->rounded_values = all.rows.converter.rounded;
    report->clamped_values = all.rows.converter.clamped;
    report->nan_values = all.rows.converter.nan;
    return status;
}

ost_status ost_nrrd_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                         ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                         ost_element *element, ost_error *err)
{
    const char *path = ost_input_path(input);
    ost_nrrd_text text;
    ost_nrrd_header header;
    ost_placement placement;
    if (options && options->form != OST_FORM_AUTO)
        return ost_fail(err, OST_ERR_USAGE, "%s: is an NRRD file; --form needs a NIfTI file", path);
    ost_status status = ost_nrrd_text_read(input, NULL, &text, err);
    uint64_t header_end = ost_input_offset(input);
    if (status == OST_OK)
        status = ost_nrrd_header_mean(path, &text, &header, err);
    if (status == OST_OK) {
        snprintf(report->type, sizeof report->type, "%s", ost_element_name(header.element));
        snprintf(report->encoding, sizeof report->encoding, "%s", encoding_names[header.encoding]);
        report->labels = text.labels;
        *element = header.element;
        *meta = text.meta;
        status = ost_volume_orientation(path, options, &header.affine, &header.oriented, meta, report, err);
    }
    if (status == OST_OK)
        status = ost_volume_resolve(path, &header.affine, header.sizes, options, header.oriented, &placement, geometry,
                                    report, err);
    if (status == OST_OK && target) {
        status = read_voxels(path, &text, &header, header_end, options, &placement, geometry, target, report, err);
    }
    ost_nrrd_text_free(&text);
    return status;
}
