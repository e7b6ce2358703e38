/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon export`: writes a bone for other programs or as a picture.
 *
 *   .nrrd .nii .nii.gz .mha .txt   the voxels, or a label map of the bone
 *   .stl .ply .obj                 the surface, closed
 *   .png                           slices, or a view of the surface
 *
 * The verb also writes a session as a table, .csv.
 */
#include "app/export/export.h"

static ost_status check_args(app_state *app, const export_args *args, ost_error *err)
{
    bool png = ends_with(args->out, "png");
    if (!png && (args->slices || args->view.view_given || args->view.size || args->target.at_given))
        return usage_error(app, err, "--slices, --view, --at and --size need a .png file, not %s", args->out);
    if (args->slices && args->view.view_given)
        return usage_error(app, err, "--slices and --view cannot be combined");
    if (args->decimals && !ends_with(args->out, "txt"))
        return usage_error(app, err, "--decimals needs a .txt file, not %s", args->out);
    if (args->omit_empty && !ends_with(args->out, "txt"))
        return usage_error(app, err, "--omit-empty needs a .txt file, not %s", args->out);
    if (args->labels && !(ends_with(args->out, "nrrd") || ends_with(args->out, "nii") ||
                          ends_with(args->out, "nii.gz") || ends_with(args->out, "mha")))
        return usage_error(app, err, "--labels needs a .nrrd, .nii, .nii.gz or .mha file, not %s", args->out);
    if (ends_with(args->out, "mcap") || ends_with(args->out, "h5") || ends_with(args->out, "hdf5"))
        return usage_error(app, err,
                           "%s: this command does not write the format: export the session to a table, --out "
                           "FILE.csv, or use the Python package (docs/guide/python.md)",
                           args->out);
    return out_check(app, args->out, "nrrd|nii|nii.gz|mha|txt|stl|ply|obj|png|csv", err);
}

ost_status cmd_export(app_state *app, int argc, char **argv, ost_error *err)
{
    export_args args = {0};
    target_options *t = &args.target;
    const operand operands[] = {{"BONE", &args.bone, "no bone given"}, {0}};
    const option options[] = {
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .required = true,
         .help = "volume: .nrrd, .nii, .nii.gz, .mha or .txt; surface: .stl, .ply or .obj; picture: .png; "
                 "session: .csv"},
        {.name = "threshold",
         .kind = OPTION_INTEGER,
         .out = &args.threshold,
         .given = &args.threshold_given,
         .value = "HU",
         .min = 1,
         .max = 32767,
         .help = "lowest density of bone (default: as in the bone's file, else 120)"},
        {.name = "slices",
         .kind = OPTION_FLAG,
         .out = &args.slices,
         .help = ".png: an axial, a coronal and a sagittal slice (default)"},
        VIEW_OPTION(args.view, ".png: the surface as osteon render draws it, in this direction"),
        VIEW_EXTENT_OPTION(args.view),
        {.name = "before",
         .kind = OPTION_TEXT,
         .out = &args.before,
         .value = "BONE",
         .help = "the bone before removal: a .png colours the bone removed since; any other file contains only the "
                 "bone removed since"},
        {.name = "labels",
         .kind = OPTION_FLAG,
         .out = &args.labels,
         .help = "write a label map for 3D Slicer: 1 for bone, 0 elsewhere"},
        TARGET_OPTIONS(*t, ".png: point through which the slices pass (default: the middle), or at which the view is "
                           "directed (default: the glenoid's centre in the file)"),
        {.name = "size",
         .kind = OPTION_TEXT,
         .out = &args.view.size,
         .value = "WxH",
         .help = ".png: size of a view in pixels (default: 800x800), or one number, the longest side of a slice "
                 "(default: 480)"},
        {.name = "decimals",
         .kind = OPTION_INTEGER,
         .out = &args.decimals,
         .value = "N",
         .min = 1,
         .max = 9,
         .help = "digits after the decimal point in a .txt (default: as many as needed)"},
        {.name = "omit-empty",
         .kind = OPTION_FLAG,
         .out = &args.omit_empty,
         .help = ".txt: omit the lines of voxels of density 0; the file is then read as the box of the other voxels"},
        COMPRESS_OPTION(args.compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "BONE --out FILE [options]",
        .about = "Writes a bone in the format of FILE: its voxels, its surface or a picture. BONE may\n"
                 "also be a CT or a tool grid. A session is written as a table with a row for each\n"
                 "tick.",
        .operands = operands,
        .streams = true,
        .options = options,
        .notes = "Lengths are in millimetres, in the bone's frame (LPS). A surface is closed, and its\n"
                 "file states the frame in the form that 3D Slicer reads (SPACE=LPS). A text file is\n"
                 "first converted into a bone, as by osteon import.",
        .example = "  osteon export reamed.nrrd --out reamed.stl\n"
                   "  osteon export reamed.nrrd --before scapula.nrrd --view en-face --out reamed.png\n"
                   "  osteon export reamed.nrrd --before scapula.nrrd --out removed.stl\n"
                   "  osteon export today.session --out today.csv",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    return export_file(app, &args, err);
}
