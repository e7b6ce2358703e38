/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon diff`: shows how two grids differ, from the verdict down to single voxels.
 *
 * Two grids are equal if their geometry and all their voxels are equal. Facts in a file's header
 * (such as the glenoid's position) affect neither voxels nor the verdict; they are compared and
 * printed separately.
 */
#include "app/diff/diff.h"

ost_status cmd_diff(app_state *app, int argc, char **argv, ost_error *err)
{
    diff_args args = {.limit = 10, .chunk = 1};
    const operand operands[] = {
        {"A", &args.name_a, "no grids given; expected two"}, {"B", &args.name_b, "no second grid given"}, {0}};
    const option options[] = {
        {.name = "html", .kind = OPTION_OUTPUT, .out = &args.html, .value = "FILE",
         .help = "write a page with slices, a view of the surface with the most differences, a map of the chunks "
                 "and the voxels"},
        {.name = "limit", .kind = OPTION_INTEGER, .out = &args.limit, .value = "N", .min = 0, .max = 100000,
         .help = "number of voxels to print (default: 10)"},
        {.name = "chunk", .kind = OPTION_CHOICE, .out = &args.chunk, .value = "16|32|64",
         .help = "edge length of the chunks for the counts, in voxels (default: 32)"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "A B [--html FILE] [options]",
        .about = "Prints whether two grids differ, and in which pattern, chunks and voxels. A and B\n"
                 "are two bones, two CTs or two tools. They can also be two bundles of osteon\n"
                 "validate, whose digests are compared for each stage, tick and chunk.",
        .operands = operands,
        .options = options,
        .notes = "Exit status 0 if they are equal (same dimensions, spacing, origin and voxels), 1 if\n"
                 "they differ. Two lengths are equal if they differ by at most 2^-23 of their size,\n"
                 "the precision of float32 in a NIfTI file. Other facts in the headers are not\n"
                 "compared. A text file is first converted into a bone, as by osteon import. Two\n"
                 "bundles are equal if every case of both was compared and is equal.",
        .example = "  osteon diff scapula.nrrd reamed.nrrd --html difference.html\n"
                   "  osteon diff our-bundle their-bundle",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.html && (status = out_check(app, args.html, "html|htm", err)) != OST_OK)
        return status;
    const bool folder = diff_is_folder(args.name_a);
    if (folder != diff_is_folder(args.name_b))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s is a folder and %s is not; expected two grids, two tools or two bundles",
                        folder ? args.name_a : args.name_b, folder ? args.name_b : args.name_a);
    if (folder) {
        if (args.html)
            return usage_error(app, err, "--html needs grids, not bundles");
        return diff_bundles(app, args.name_a, args.name_b, args.limit, err);
    }
    return diff_grids(app, &args, err);
}
