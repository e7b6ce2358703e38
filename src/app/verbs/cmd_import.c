/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon import`: makes a bone of cubic voxels from a CT (thesis, Algs. 2.2 - 2.6).
 */
#include "app/common/backend_choice.h"
#include "app/input/load.h"
#include "app/input/patient.h"
#include "app/input/proposal.h"
#include "app/input/segment_options.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/picture/previews.h"

/*
 * Warns if a grid is too small or too large for a patient's bone. The warning names the units that would make the size
 * plausible. Such a size is not an error, because a micro-CT may be this small. A phantom is marked in its header and
 * causes no warning.
 */
static void warn_size(const app_state *app, const char *name, const ost_import_result *r)
{
    const ost_geometry *g = &r->rect;
    const double size[3] = {g->dims.x * ost_pm_to_mm(g->spacing.x), g->dims.y * ost_pm_to_mm(g->spacing.y),
                            g->dims.z * ost_pm_to_mm(g->spacing.z)};
    double largest = size[0] > size[1] ? size[0] : size[1];
    char text[LOAD_UNITS_TEXT];
    largest = largest > size[2] ? largest : size[2];
    if ((largest >= 20 && largest <= 3000) || ost_meta_get(&r->meta, "phantom"))
        return;
    warn(app, "%s: the CT is %.3g mm across, too %s for a patient's bone%s", name, largest,
         largest < 20 ? "small" : "large", load_other_units(text, largest));
}

static void put_result(const app_state *app, const ost_import_result *r, const ost_bone_info *info)
{
    json_t *o = app->result;
    put_text(o, "format", load_kind_name(r->kind));
    put_dims(o, "rect_dims", r->rect.dims);
    put_mm3(o, "rect_spacing_mm", r->rect.spacing);
    put(o, "spacing_inferred",
        json_pack("[b,b,b]", r->spacing_inferred[0], r->spacing_inferred[1], r->spacing_inferred[2]));
    put_dims(o, "cubic_dims", r->cubic.dims);
    put_mm(o, "cubic_spacing_mm", r->cubic.spacing.x);
    put_mm3(o, "origin_mm", r->cubic.origin);
    put_text(o, "resample", ost_resample_name(r->resample));
    put_integer(o, "threshold", info->threshold);
    put_integer(o, "chunk", info->chunk_size);
    put_dims(o, "chunk_dims", info->chunk_dims);
    put_integer(o, "chunks", info->chunks);
    put_integer(o, "active_chunks", info->active_chunks);
    put_integer(o, "active_voxels", info->active_voxels);
    put_integer(o, "chunk_bytes", info->chunk_bytes);
    if (r->kind == OST_FILE_CT_TEXT) {
        put_integer(o, "samples", (int64_t)r->scatter.samples);
        put_integer(o, "duplicates", (int64_t)r->scatter.duplicates);
        put_integer(o, "off_lattice", (int64_t)r->scatter.off_lattice);
        put_real(o, "worst_offset_voxels", (double)r->scatter.worst_offset_ppm * 1e-6);
        put_integer(o, "rounded_positions", (int64_t)r->rounded_positions);
    } else {
        put_text(o, "element_type", r->volume.type);
        put_text(o, "encoding", r->volume.encoding);
        put_text(o, "orientation", r->volume.orientation);
        put_bool(o, "orientation_assumed", r->volume.assumed);
        put_bool(o, "reoriented", r->volume.reoriented);
        put_bool(o, "resampled", r->volume.resampled);
        put_bool(o, "labels", r->volume.labels);
        put_integer(o, "rounded_values", (int64_t)r->volume.rounded_values);
        put_integer(o, "clamped_values", (int64_t)r->volume.clamped_values);
        put_integer(o, "nan_values", (int64_t)r->volume.nan_values);
        if (r->kind == OST_FILE_STACK)
            put(o, "pixel_mm", json_pack("[f,f]", r->volume.pixel_mm[0], r->volume.pixel_mm[1]));
    }
    if (r->kind == OST_FILE_DICOM)
        put_dicom_report(o, &r->volume.dicom);
    if (r->mask.selected) {
        put_integer(o, "mask_voxels", (int64_t)r->mask.selected);
        put_integer(o, "mask_removed", (int64_t)r->mask.removed);
        put_integer(o, "mask_filled", (int64_t)r->mask.filled);
    }
    if (r->labels.selected) {
        put_integer(o, "bone_voxels", (int64_t)r->labels.selected);
        put_integer(o, "bone_removed", (int64_t)r->labels.removed);
        put_integer(o, "bone_filled", (int64_t)r->labels.filled);
    }
    json_t *stages = json_array();
    for (int i = 0; i < r->stage_count; i++) {
        json_t *stage = json_object();
        put_text(stage, "name", r->stages[i].name);
        put_real(stage, "time_ms", r->stages[i].time_ms);
        if (r->stages[i].has_digest)
            put_digest(stage, "sha256", &r->stages[i].digest);
        append(stages, stage);
    }
    put(o, "stages", stages);
    put_meta(o, "meta", &r->meta);
}

static void print_result(const app_state *app, const char *ct, const char *out, const ost_import_result *r,
                         const ost_bone_info *info)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT], d[FORMAT_TEXT];
    bool found = r->spacing_inferred[0] || r->spacing_inferred[1] || r->spacing_inferred[2];
    print_line(app, "%s: %s, %s voxels at %s%s%s", ct, load_kind_name(r->kind), format_dims(a, r->rect.dims),
               format_spacing(b, r->rect.spacing), found ? " (spacing found from the positions)" : "",
               r->volume.reoriented ? " (axes turned to LPS)" : "");
    if (r->volume.pixel_mm[0] > 0 && r->volume.pixel_mm[1] > 0)
        print_line(app, "  its first slice states %.6g x %.6g mm per pixel, which is not used", r->volume.pixel_mm[0],
                   r->volume.pixel_mm[1]);
    const ost_dicom_report *dicom = &r->volume.dicom;
    const bool thick = dicom->thickness && dicom->thickness != r->rect.spacing.z;
    if (dicom->images)
        print_line(app, "  %s slices, %s%s", format_count(a, dicom->images), r->volume.encoding,
                   thick ? ", thickness differs from distance" : "");
    if (r->mask.selected)
        print_line(app, "  mask: %s voxels selected, %s dense voxels elsewhere removed, %s filled",
                   format_count(a, (int64_t)r->mask.selected), format_count(b, (int64_t)r->mask.removed),
                   format_count(c, (int64_t)r->mask.filled));
    if (r->labels.selected)
        print_line(app, "  bone: %s voxels selected, %s dense voxels elsewhere removed, %s filled",
                   format_count(a, (int64_t)r->labels.selected), format_count(b, (int64_t)r->labels.removed),
                   format_count(c, (int64_t)r->labels.filled));
    print_line(app, "%s: %s cubic voxels of %s, %s of them bone (%d HU or more)", out, format_dims(a, r->cubic.dims),
               format_spacing(b, r->cubic.spacing), format_count(c, info->active_voxels), info->threshold);
    print_line(app, "  %s chunks of %d^3, %s of %s in use, %s", format_dims(a, info->chunk_dims), info->chunk_size,
               format_count(b, info->active_chunks), format_count(c, info->chunks), format_bytes(d, info->chunk_bytes));
    for (int i = 0; i < r->stage_count; i++)
        print_line(app, "  %-8s %9s", r->stages[i].name, format_time(a, r->stages[i].time_ms));
}

ost_status cmd_import(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *name = NULL, *out = NULL, *preview = NULL;
    ct_options ct = CT_OPTIONS_DEFAULT;
    segment_options segment = SEGMENT_OPTIONS_DEFAULT;
    patient_options patient = {.landmarks = NULL};
    bool compress = false;
    const operand operands[] = {{"CT", &name, "no CT given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &out, .value = "FILE", .required = true,
         .help = "the bone: .nrrd, .nii, .nii.gz or .txt"},
        HEADING("reading the CT"),
        CT_OPTIONS(ct),
        HEADING("selecting a bone"),
        {.name = "mask", .kind = OPTION_TEXT, .out = &ct.mask, .value = "FILE[:LABEL,...]",
         .help = "label map on the grid of the CT or a part of it: only voxels with one of these labels, given as "
                 "numbers or names (default: any but 0), can be bone"},
        {.name = "mask-names", .kind = OPTION_TEXT, .out = &ct.mask_names, .value = "FILE",
         .help = "names of the labels: lines \"3 scapula\", CSV or JSON (default: those in the label map's header)"},
        {.name = "mask-fill", .kind = OPTION_FLAG, .out = &ct.mask_fill,
         .help = "raise voxels of the mask below the threshold to the threshold"},
        SEGMENT_OPTIONS(segment),
        HEADING("landmarks, stored in the bone's header"),
        PATIENT_OPTIONS(patient),
        HEADING("writing"),
        PREVIEW_OPTION(preview),
        COMPRESS_OPTION(compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "CT --out BONE.nrrd [options]",
        .about = "Converts a CT into a bone of cubic voxels. Voxels below the threshold are empty. CT\n"
                 "is a text file of lines \"x y z density\", an NRRD, NIfTI or MetaImage file, a folder\n"
                 "of DICOM files, or a stack of TIFF or PNG slices: a folder, a pattern in quotes, or\n"
                 "a TIFF with several pages.",
        .operands = operands,
        .streams = true,
        .options = options,
        .notes = "Lengths are in millimetres, densities in HU. The axes of the grid are made to point\n"
                 "to the patient's left, back and head (LPS); the axes of a text file are not\n"
                 "changed. The positions in a text file are voxel centres, in any order.",
        .example = "  osteon import shoulder.nii.gz --out shoulder.nrrd\n"
                   "  osteon import scan/ --series 3 --out shoulder.nrrd\n"
                   "  osteon import shoulder.nii.gz --landmarks F.mrk.json --out shoulder.nrrd\n"
                   "  osteon import shoulder.nii.gz --mask labels.nrrd:1 --landmarks auto --out scapula.nrrd\n"
                   "  osteon import 'scan/*.tif' --spacing 0.0195 --threshold 63 --out core.nrrd\n"
                 "  osteon import shoulder.nii.gz --cut-head auto --bone -98,200,-159 --out scapula.nrrd\n"
                   "  osteon import scapula.txt --threshold 150 --cubic 0.5 --out scapula.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) ||
        (status = out_check(app, out, "nrrd|nii|nii.gz|txt", err)) != OST_OK ||
        (status = patient_check(app, &patient, err)) != OST_OK ||
        (status = preview_check(app, preview, err)) != OST_OK)
        return status;

    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result result = {0};
    ost_bone_info info;
    ost_digest file;
    const ost_write_options write = {.compress = compress, .progress = progress_show};
    segment_job job;
    if ((status = segment_job_init(&job, app, &segment, err)) != OST_OK)
        return status;
    if (segment_is_given(&segment)) {
        ct.labels = segment_job_labels;
        ct.labels_user = &job;
    }
    status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, name, &ct, true, &bone, &result, err);
    if (status == OST_OK)
        status = patient_take(app, &patient, bone, name, &result.cubic, &result.meta, err);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK && info.active_voxels == 0)
        warn(app,
             result.volume.labels
                 ? "%s: no voxel has %d HU or more; the bone is empty; the CT is a label map: pass it to --mask, or "
                   "pass --threshold 1 to import its labels as bone"
                 : "%s: no voxel has %d HU or more; the bone is empty",
             name, info.threshold);
    if (status == OST_OK)
        warn_size(app, name, &result);
    if (status == OST_OK && preview)
        status = preview_import(app, preview, name, out, &ct, bone, &result, err);
    if (status == OST_OK)
        status = ost_bone_write(out, bone, &result.meta, &write, err);
    if (status == OST_OK && (status = file_digest(out, &file, err)) == OST_OK) {
        put_text(app->result, "in", name);
        put_text(app->result, "out", out);
        put_result(app, &result, &info);
        put_digest(app->result, "file_sha256", &file);
        if (preview)
            put_text(app->result, "preview", preview);
        if (ct.labels)
            segment_job_report(&job, name);
        print_result(app, name, out, &result, &info);
        status = angles_report(app, &result.meta, err);
    }
    segment_job_free(&job);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return status;
}
