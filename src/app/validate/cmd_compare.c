/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon compare`: compares the grids of another program with those of the reference,
 * and reports the margin of every difference.
 *
 *   a folder of dumps, or a backend's name --campaign--> verdicts, margins --> table, --json, exit status
 *
 * The comparison is the same as in `osteon validate`, but the verb makes neither a bundle nor a sensitivity proof. The
 * verb is intended for developers of another program.
 */
#include "app/validate/compare.h"

ost_status cmd_compare(app_state *app, int argc, char **argv, ost_error *err)
{
    compare_args args = {.seed = 1, .limit_s = 3600, .own = USER_FILES_DEFAULT};
    const operand names[] = {{"DUMPS", &args.subject_spec, "no dumps or backend given"}, {NULL, NULL, NULL}};
    const option options[] = {
        {.name = "only",
         .kind = OPTION_TEXT,
         .out = &args.only,
         .value = "CASE",
         .help = "compare the cases whose name starts with CASE, such as import, static/2 or operation"},
        {.name = "apart",
         .kind = OPTION_FLAG,
         .out = &args.apart,
         .help = "give every stage and tick the reference's input, so that a difference does not affect later "
                 "stages; not for dumps"},
        {.name = "tier",
         .kind = OPTION_CHOICE,
         .out = &args.tier,
         .given = &args.tier_given,
         .value = "smoke|standard|full",
         .help = "tier of the cases (default: smoke; a dump states its own)"},
        {.name = "seed",
         .kind = OPTION_INTEGER,
         .out = &args.seed,
         .given = &args.seed_given,
         .value = "N",
         .min = 1,
         .max = INT64_MAX,
         .help = "seed of the cases (default: 1; a dump states its own)"},
        {.name = "limit",
         .kind = OPTION_INTEGER,
         .out = &args.limit_s,
         .value = "S",
         .min = 1,
         .max = 1000000,
         .help = "seconds after which a backend is stopped (default: 3600)"},
        HEADING("your own files"),
        USER_FILES(args.own, "a CT of your own, for case user/1 as in osteon validate; may repeat",
                   "a mesh of your own, or builtin:reamer; may repeat",
                   "a CSV, builtin:peg-hole or builtin:glenoid-ream; may repeat"),
        HEADING("reading your own files"),
        USER_FILES_HOW(args.own),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "DUMPS | BACKEND [options]",
        .about = "Compares the grids of another program with those of the scalar reference, stage by\n"
                 "stage. For every voxel that differs, prints a margin, which states how close the\n"
                 "voxel was to the other result.\n"
                 "DUMPS is a folder with a dump.json (docs/spec/dumps.md); BACKEND is the name of a\n"
                 "backend, such as plugin:./mine.so.",
        .operands = names,
        .options = options,
        .notes = "The reference determines a voxel by the position of a point. The margin of a voxel\n"
                 "is the distance, on its worst axis, from this point to the nearest border beyond\n"
                 "which the other result would be correct. Rounding gives margins near 0. A\n"
                 "difference that no border explains is not caused by rounding.",
        .example = "  osteon validate --export-cases cases --only import/0   # inputs, for your program\n"
                   "  osteon compare my-dumps\n"
                   "  osteon compare plugin:./thesis_f32.so --only static --apart\n"
                   "  osteon compare my-dumps --only user --ct shoulder.nii.gz --tool reamer.stl",
    };
    ost_status status;
    return options_parse(app, &usage, argc, argv, &status, err) ? compare_run(app, &args, argc, argv, err) : status;
}
