/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon segment`: divides a CT into bones and writes them as a label map.
 */
#include <string.h>

#include "app/input/load.h"
#include "app/input/segment_options.h"
#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/picture/previews.h"

enum { THRESHOLD = 120 };

/* Adds the header facts of the CT to those of the label map, and marks the grid as a label map. */
static ost_status add_facts(ost_meta *meta, const ost_meta *of_ct, ost_error *err)
{
    const ost_meta own = *meta;
    *meta = *of_ct;
    ost_status status = ost_meta_set(meta, OST_META_KIND, "labels", err);
    for (int i = 0; i < own.count && status == OST_OK; i++)
        status = ost_meta_set(meta, own.entry[i].key, own.entry[i].value, err);
    return status;
}

ost_status cmd_segment(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *name = NULL, *out = NULL, *orientation = NULL, *preview = NULL;
    int64_t threshold = THRESHOLD;
    segment_options segment = SEGMENT_OPTIONS_DEFAULT;
    ost_pm3 at = {0, 0, 0};
    bool has_at = false, compress = false;
    dicom_options dicom = {.series = NULL};
    const operand operands[] = {{"CT", &name, "no CT given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &out, .value = "FILE", .required = true,
         .help = "the label map: .nrrd, .nii or .nii.gz"},
        HEADING("what is bone"),
        {.name = "threshold", .kind = OPTION_INTEGER, .out = &threshold, .value = "HU", .min = 1, .max = 32767,
         .help = "density that at least one voxel of each bone reaches (default: 120)"},
        SEGMENT_OPTIONS(segment),
        HEADING("reading and reporting"),
        {.name = "at", .kind = OPTION_POINT, .out = &at, .given = &has_at, .value = "X,Y,Z",
         .help = "report the label at this position"},
        {.name = "orientation", .kind = OPTION_TEXT, .out = &orientation, .value = "XYZ",
         .help = "directions of the axes of a CT whose file does not state them, such as LPS or RAS (default: LPS, "
                 "with a warning)"},
        DICOM_OPTIONS(dicom),
        PREVIEW_OPTION(preview),
        COMPRESS_OPTION(compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "CT --out LABELS.nrrd [options]",
        .about = "Divides a CT (NRRD, NIfTI, MetaImage or a folder of DICOM files) into bones:\n"
                 "components of dense voxels that share faces. Label 1 is the largest. osteon import\n"
                 "--mask LABELS.nrrd:1 imports the bone with label 1; osteon import also accepts the\n"
                 "options that select a bone.",
        .operands = operands,
        .streams = true,
        .options = options,
        .notes = "Lengths are in millimetres in the patient's axes (LPS), densities in HU. The label\n"
                 "map is the same on every machine.",
        .example = "  osteon segment shoulder.nii.gz --out labels.nrrd\n"
                   "  osteon segment shoulder.nii.gz --cut-ball -142,196,-159,26 --out labels.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) ||
        (status = out_check(app, out, "nrrd|nii|nii.gz", err)) != OST_OK ||
        (status = preview_check(app, preview, err)) != OST_OK)
        return status;
    ost_volume_options read = {.progress = progress_show};
    ost_volume_report report;
    ost_volume ct = {0}, labels = {0};
    segment_job job;
    if (segment.growth > threshold)
        return usage_error(app, err, "--growth %lld: expected at most the threshold, %lld", (long long)segment.growth,
                           (long long)threshold);
    if (orientation && strlen(orientation) != 3)
        return usage_error(app, err, "--orientation '%s': expected three letters, such as LPS or RAS", orientation);
    if (orientation)
        memcpy(read.orientation, orientation, sizeof read.orientation);
    status = segment_job_init(&job, app, &segment, err);
    load_dicom_options(&dicom, &read);
    if (status == OST_OK)
        status = ost_volume_read(name, &read, &ct, &report, err);
    if (status == OST_OK) {
        progress_show(NULL, "segmenting", 0);
        status = segment_job_run(&job, &ct, (int32_t)threshold, &labels, err);
        if (status == OST_OK)
            status = add_facts(&labels.meta, &ct.meta, err);
        if (status != OST_OK)
            (void)ost_fail_context(err, "%s", name);
    }
    if (status == OST_OK)
        load_warn_orientation(app, name, &ct.meta);
    if (status == OST_OK)
        load_warn_dicom(app, name, &report.dicom);
    if (status == OST_OK && preview)
        status = preview_segment(app, preview,
                                 &(preview_labels){name, out, &ct, &labels, &report, job.segments, job.count,
                                                   (int32_t)threshold, has_at, at},
                                 err);
    if (status == OST_OK)
        status = ost_volume_write(out, &labels,
                                  &(ost_write_options){.compress = compress, .progress = progress_show}, err);
    if (status == OST_OK) {
        put_text(app->result, "in", name);
        put_text(app->result, "out", out);
        if (preview)
            put_text(app->result, "preview", preview);
        segment_job_report(&job, out);
        if (!job.found)
            warn(app, "%s: no bone of %g mm3 or more reaches %d HU; pass a lower --threshold or --min-volume", name,
                 segment_job_min_mm3(&job), (int)threshold);
        if (has_at) {
            const int label = ost_segment_label_at(&labels, at);
            put_integer(app->result, "label_at", label);
            print_line(app, "  at %.9g,%.9g,%.9g: %s", ost_pm_to_mm(at.x), ost_pm_to_mm(at.y), ost_pm_to_mm(at.z),
                       label < 0 ? "outside the CT" : label ? "" : "no label");
            if (label > 0)
                print_line(app, "    label %d", label);
        }
    }
    segment_job_free(&job);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
    return status;
}
