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

typedef struct segment_args {
    const char *name, *out, *orientation, *preview;
    int64_t threshold;
    segment_options segment;
    ost_pm3 at;
    bool has_at, compress;
    dicom_options dicom;
} segment_args;

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

static void report_labels(const app_state *app, const segment_args *args, const segment_job *job,
                          const ost_volume *labels)
{
    put_text(app->result, "in", args->name);
    put_text(app->result, "out", args->out);
    if (args->preview)
        put_text(app->result, "preview", args->preview);
    segment_job_report(job, args->out);
    if (!job->found)
        warn(app, "%s: no bone of %g mm3 or more reaches %d HU; pass a lower --threshold or --min-volume", args->name,
             segment_job_min_mm3(job), (int)args->threshold);
    if (args->has_at) {
        const ost_pm3 at = args->at;
        const int label = ost_segment_label_at(labels, at);
        put_integer(app->result, "label_at", label);
        print_line(app, "  at %.9g,%.9g,%.9g: %s", ost_pm_to_mm(at.x), ost_pm_to_mm(at.y), ost_pm_to_mm(at.z),
                   label < 0 ? "outside the CT" : label ? "" : "no label");
        if (label > 0)
            print_line(app, "    label %d", label);
    }
}

static ost_status segment_ct(const app_state *app, const segment_args *args, ost_error *err)
{
    ost_volume_options read = {.progress = progress_show};
    ost_volume_report report;
    ost_volume ct = {0}, labels = {0};
    segment_job job;
    if (args->orientation)
        memcpy(read.orientation, args->orientation, sizeof read.orientation);
    ost_status status = segment_job_init(&job, app, &args->segment, err);
    load_dicom_options(&args->dicom, &read);
    if (status == OST_OK)
        status = ost_volume_read(args->name, &read, &ct, &report, err);
    if (status == OST_OK) {
        progress_show(NULL, "segmenting", 0);
        status = segment_job_run(&job, &ct, (int32_t)args->threshold, &labels, err);
        if (status == OST_OK)
            status = add_facts(&labels.meta, &ct.meta, err);
        if (status != OST_OK)
            (void)ost_fail_context(err, "%s", args->name);
    }
    if (status == OST_OK)
        load_warn_orientation(app, args->name, &ct.meta);
    if (status == OST_OK)
        load_warn_dicom(app, args->name, &report.dicom);
    if (status == OST_OK && args->preview)
        status = preview_segment(app, args->preview,
                                 &(preview_labels){args->name, args->out, &ct, &labels, &report, job.segments,
                                                   job.count, (int32_t)args->threshold, args->has_at, args->at},
                                 err);
    if (status == OST_OK)
        status = ost_volume_write(args->out, &labels,
                                  &(ost_write_options){.compress = args->compress, .progress = progress_show}, err);
    if (status == OST_OK)
        report_labels(app, args, &job, &labels);
    segment_job_free(&job);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
    return status;
}

ost_status cmd_segment(app_state *app, int argc, char **argv, ost_error *err)
{
    segment_args args = {.threshold = THRESHOLD, .segment = SEGMENT_OPTIONS_DEFAULT};
    const operand operands[] = {{"CT", &args.name, "no CT given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &args.out, .value = "FILE", .required = true,
         .help = "the label map: .nrrd, .nii or .nii.gz"},
        HEADING("what is bone"),
        {.name = "threshold", .kind = OPTION_INTEGER, .out = &args.threshold, .value = "HU", .min = 1, .max = 32767,
         .help = "density that at least one voxel of each bone reaches (default: 120)"},
        SEGMENT_OPTIONS(args.segment),
        HEADING("reading and reporting"),
        {.name = "at", .kind = OPTION_POINT, .out = &args.at, .given = &args.has_at, .value = "X,Y,Z",
         .help = "report the label at this position"},
        {.name = "orientation", .kind = OPTION_TEXT, .out = &args.orientation, .value = "XYZ",
         .help = "directions of the axes of a CT whose file does not state them, such as LPS or RAS (default: LPS, "
                 "with a warning)"},
        DICOM_OPTIONS(args.dicom),
        PREVIEW_OPTION(args.preview),
        COMPRESS_OPTION(args.compress),
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
        (status = out_check(app, args.out, "nrrd|nii|nii.gz", err)) != OST_OK ||
        (status = preview_check(app, args.preview, err)) != OST_OK)
        return status;
    if (args.segment.growth > args.threshold)
        return usage_error(app, err, "--growth %lld: expected at most the threshold, %lld",
                           (long long)args.segment.growth, (long long)args.threshold);
    if (args.orientation && strlen(args.orientation) != 3)
        return usage_error(app, err, "--orientation '%s': expected three letters, such as LPS or RAS",
                           args.orientation);
    return segment_ct(app, &args, err);
}
