/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a DICOM series as a volume:
 *
 *   path --scan.c--> images --series.c--> one series --stack.c--> grid --slices.c--> rows --volume/rows.c--> volume
 */
#include "io/dicom/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/dicom/series.h"
#include "io/dicom/slices.h"
#include "io/dicom/stack.h"
#include "io/volume/memory.h"

bool ost_dicom_sniff(const unsigned char *head, size_t size)
{
    return size >= 132 && memcmp(head + 128, "DICM", 4) == 0;
}

static ost_status scan_path(const char *path, ost_dicom_launch *launch, char program[OST_DICOM_PATH_MAX],
                            ost_dicom_scan *out, ost_error *err)
{
    *out = (ost_dicom_scan){0};
    ost_status status = ost_dicom_program(path, program, err);
    *launch = (ost_dicom_launch){.program = program};
    return status == OST_OK ? ost_dicom_scan_path(path, launch, out, err) : status;
}

static ost_status read_voxels(const ost_dicom_stack *stack, const ost_dicom_launch *launch,
                              const ost_volume_options *options, const ost_placement *placement,
                              const ost_geometry *geometry, const ost_target *target,
                              ost_volume_report *report, ost_error *err)
{
    ost_dicom_slices *slices = malloc(sizeof *slices);
    if (!slices)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu bytes", stack->scan->path, sizeof *slices);
    ost_status status = ost_memory_check(stack->scan->path, "volume", geometry->dims, err);
    if (status == OST_OK) {
        status = ost_dicom_slices_open(stack, launch, options && options->clamp, slices, err);
        slices->rows.options = options;
        if (status == OST_OK)
            status = ost_volume_fill(&slices->rows, &stack->affine, placement, geometry, target, err);
        report->rounded_values = slices->table.rounded;
        report->clamped_values = slices->table.clamped;
        report->dicom.padded = slices->table.padded;
        report->dicom.interpolated = slices->interpolated;
        ost_dicom_slices_close(slices);
    }
    free(slices);
    return status;
}

ost_status ost_dicom_read(const char *path, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                          ost_error *err)
{
    char program[OST_DICOM_PATH_MAX];
    ost_dicom_launch launch;
    ost_dicom_scan scan;
    ost_dicom_stack stack = {0};
    ost_placement placement;
    size_t series;
    bool oriented = true;
    if (options && options->form != OST_FORM_AUTO)
        return ost_fail(err, OST_ERR_USAGE, "%s: is DICOM; --form needs a NIfTI file", path);
    *element = OST_ELEMENT_INT16;
    ost_status status = scan_path(path, &launch, program, &scan, err);
    if (status == OST_OK)
        status = ost_dicom_series_select(&scan, options ? options->series : NULL, &series, err);
    if (status == OST_OK)
        status = ost_dicom_stack_make(&scan, series, options, &stack, &report->dicom, err);
    if (status == OST_OK)
        status = ost_volume_orientation(path, options, &stack.affine, &oriented, meta, report, err);
    if (status == OST_OK)
        status = ost_volume_resolve(path, &stack.affine, stack.sizes, options, oriented, &placement, geometry, report,
                                    err);
    if (status == OST_OK) {
        const ost_dicom_frame *first = stack.images[0];
        snprintf(report->type, sizeof report->type, "%sint%d", first->flags & OST_DICOM_IMAGE_SIGNED ? "" : "u",
                 first->bits_allocated);
        snprintf(report->encoding, sizeof report->encoding, "%s", first->encoding);
        if (target)
            status = read_voxels(&stack, &launch, options, &placement, geometry, target, report, err);
    }
    ost_dicom_stack_free(&stack);
    ost_dicom_scan_free(&scan);
    return status;
}

/* -------------------------------------------------------------------- list */

static void describe(const ost_dicom_scan *scan, size_t series, const ost_volume_options *options,
                     ost_dicom_series *out)
{
    const ost_dicom_group *group = &scan->series[series];
    *out = (ost_dicom_series){.numbered = group->numbered,
                              .number = group->number,
                              .images = group->images,
                              .localizers = group->localizers};
    snprintf(out->description, sizeof out->description, "%s", group->description);
    snprintf(out->uid, sizeof out->uid, "%s", group->uid);
    snprintf(out->kernel, sizeof out->kernel, "%s", group->kernel);
    snprintf(out->modality, sizeof out->modality, "%.*s", (int)sizeof out->modality - 1, group->modality);
    if (group->images < 2)
        return;
    ost_error err = {0};
    ost_dicom_stack stack;
    ost_dicom_report dicom;
    ost_volume_report report = {0};
    ost_placement placement;
    ost_status status = ost_dicom_stack_make(scan, series, options, &stack, &dicom, &err);
    if (status == OST_OK) {
        out->thickness = dicom.thickness;
        status = ost_volume_resolve(scan->path, &stack.affine, stack.sizes, options, true, &placement, &out->geometry,
                                    &report, &err);
        ost_dicom_stack_free(&stack);
    }
    out->is_volume = status == OST_OK;
    if (out->is_volume)
        snprintf(out->orientation, sizeof out->orientation, "%.3s", report.orientation);
    else
        snprintf(out->fault, sizeof out->fault, "%s", err.text);
}

ost_status ost_dicom_list_read(const char *path, const ost_volume_options *options, ost_dicom_list *out,
                               ost_error *err)
{
    char program[OST_DICOM_PATH_MAX];
    ost_dicom_launch launch;
    ost_dicom_scan scan;
    *out = (ost_dicom_list){0};
    ost_status status = scan_path(path, &launch, program, &scan, err);
    if (status != OST_OK)
        return status;
    out->files = (int64_t)scan.files.count;
    out->other_files = (int64_t)scan.not_dicom + scan.no_image;
    if (scan.series_count) {
        out->items = calloc(scan.series_count, sizeof *out->items);
        if (!out->items)
            status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a list of %zu series", path,
                              scan.series_count);
    }
    size_t selected;
    const ost_status found = ost_dicom_series_select(&scan, options ? options->series : NULL, &selected, NULL);
    out->selected = found == OST_OK ? (int64_t)selected : -1;
    for (; status == OST_OK && out->count < scan.series_count; out->count++)
        describe(&scan, out->count, options, &out->items[out->count]);
    ost_dicom_scan_free(&scan);
    return status;
}

void ost_dicom_list_free(ost_dicom_list *list)
{
    free(list->items);
    *list = (ost_dicom_list){0};
}
