/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon import`: makes a bone of cubic voxels from a CT (thesis, Algs. 2.2 - 2.6).
 */
#include "app/import/import.h"
#include "app/picture/previews.h"

ost_status cmd_import(app_state *app, int argc, char **argv, ost_error *err)
{
    import_args args = {.ct = CT_OPTIONS_DEFAULT, .segment = SEGMENT_OPTIONS_DEFAULT};
    const operand operands[] = {{"CT", &args.name, "no CT given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &args.out, .value = "FILE", .required = true,
         .help = "the bone: .nrrd, .nii, .nii.gz or .txt"},
        HEADING("reading the CT"),
        CT_OPTIONS(args.ct),
        HEADING("selecting a bone"),
        {.name = "mask", .kind = OPTION_TEXT, .out = &args.ct.mask, .value = "FILE[:LABEL,...]",
         .help = "label map on the grid of the CT or a part of it: only voxels with one of these labels, given as "
                 "numbers or names (default: any but 0), can be bone"},
        {.name = "mask-names", .kind = OPTION_TEXT, .out = &args.ct.mask_names, .value = "FILE",
         .help = "names of the labels: lines \"3 scapula\", CSV or JSON (default: those in the label map's header)"},
        {.name = "mask-fill", .kind = OPTION_FLAG, .out = &args.ct.mask_fill,
         .help = "raise voxels of the mask below the threshold to the threshold"},
        SEGMENT_OPTIONS(args.segment),
        HEADING("landmarks, stored in the bone's header"),
        PATIENT_OPTIONS(args.patient),
        HEADING("writing"),
        PREVIEW_OPTION(args.preview),
        COMPRESS_OPTION(args.compress),
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
        (status = out_check(app, args.out, "nrrd|nii|nii.gz|txt", err)) != OST_OK ||
        (status = patient_check(app, &args.patient, err)) != OST_OK ||
        (status = preview_check(app, args.preview, err)) != OST_OK)
        return status;
    return import_ct(app, &args, err);
}
