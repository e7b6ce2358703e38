/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon validate`: compares backends stage by stage and writes the evidence.
 *
 *   options --> a campaign, a merge of shards, or the sensitivity proof (validate.h)
 *
 * For each backend, the campaign starts the same verb with --worker. The worker runs cases on one
 * backend and writes a trace of all results.
 */
#include "app/common/options.h"
#include "app/validate/validate.h"
#include "validation/worker.h"

ost_status cmd_validate(app_state *app, int argc, char **argv, ost_error *err)
{
    validate_args args = {.seed = 1, .suite_limit_s = 1800, .own = USER_FILES_DEFAULT};
    const option options[] = {
        {.name = "out",
         .kind = OPTION_TEXT,
         .out = &args.out,
         .value = "BUNDLE",
         .help = "folder for the evidence; must not exist"},
        {.name = "tier",
         .kind = OPTION_CHOICE,
         .out = &args.tier,
         .value = "smoke|standard|full",
         .help = "number of cases: smoke takes under a minute, standard about 10 minutes, full hours (default: "
                 "smoke)"},
        {.name = "backends",
         .kind = OPTION_TEXT,
         .out = &args.backends,
         .value = "A;B",
         .help = "backends to compare with the reference (default: all that are available, and dense, a second "
                 "implementation of all steps)"},
        {.name = "cpu-only",
         .kind = OPTION_FLAG,
         .out = &args.cpu_only,
         .help = "compare the CPU's variants only; a missing OpenCL device is then no failure"},
        {.name = "seed",
         .kind = OPTION_INTEGER,
         .out = &args.seed,
         .value = "N",
         .min = 1,
         .max = INT64_MAX,
         .help = "seed of the generated cases (default: 1)"},
        {.name = "only",
         .kind = OPTION_TEXT,
         .out = &args.only,
         .value = "CASE",
         .help = "run the cases whose name starts with CASE, such as mesh or session/1"},
        {.name = "apart",
         .kind = OPTION_FLAG,
         .out = &args.apart,
         .help = "give every stage and tick the reference's input, so that each is compared on its own; writes no "
                 "bundle"},
        {.name = "limit",
         .kind = OPTION_INTEGER,
         .out = &args.limit_s,
         .value = "S",
         .min = 1,
         .max = 1000000,
         .help = "seconds after which a backend is stopped (default: 120, 1800 or 36000, by tier)"},
        {.name = "jobs",
         .kind = OPTION_INTEGER,
         .out = &args.jobs,
         .value = "N",
         .min = 1,
         .max = WORKERS_MAX,
         .help = "number of backends that run at the same time (default: number of cores)"},
        HEADING("your own files"),
        USER_FILES(args.own, "a CT of your own, for a case with all tools and paths given; may repeat",
                   "a mesh of your own, or builtin:reamer; may repeat",
                   "a CSV, builtin:peg-hole or builtin:glenoid-ream; may repeat"),
        HEADING("reading your own files"),
        USER_FILES_HOW(args.own),
        HEADING("evidence"),
        {.name = "sign",
         .kind = OPTION_TEXT,
         .out = &args.sign,
         .value = "KEY",
         .help = "sign the bundle with this private key (PEM), as osteon sign does"},
        {.name = "passphrase-file",
         .kind = OPTION_TEXT,
         .out = &args.passphrase,
         .value = "FILE",
         .help = "file whose first line is the passphrase of --sign's key"},
        {.name = "against",
         .kind = OPTION_TEXT,
         .out = &args.against,
         .value = "BUNDLE",
         .help = "with --out: report what changed since this older bundle, and why"},
        {.name = "with-suite",
         .kind = OPTION_TEXT,
         .out = &args.suite,
         .value = "FOLDER",
         .help = "with --out: run the tests that the requirements name in the folder where osteon was built (after "
                 "make check), and store their results in the bundle; a failed test gives exit status 1"},
        {.name = "suite-limit",
         .kind = OPTION_INTEGER,
         .out = &args.suite_limit_s,
         .value = "S",
         .min = 1,
         .max = 1000000,
         .help = "seconds after which a test of --with-suite is stopped (default: 1800)"},
        HEADING("sensitivity proof alone"),
        {.name = "faults-only",
         .kind = OPTION_FLAG,
         .out = &args.faults_only,
         .help = "run the sensitivity proof only: deliberate mistakes in the second implementation, none in a "
                 "backend"},
        {.name = "faults",
         .kind = OPTION_INTEGER,
         .out = &args.faults,
         .value = "N",
         .min = 1,
         .max = 100000000,
         .help = "number of mistakes, with --faults-only (default: the tier's)"},
        HEADING("several machines"),
        {.name = "shard",
         .kind = OPTION_TEXT,
         .out = &args.shard,
         .value = "I/N",
         .help = "run every N-th case only, starting with the I-th"},
        {.name = "merge",
         .kind = OPTION_TEXT,
         .out = &args.merge,
         .value = "FOLDER",
         .help = "merge the shards' bundles in FOLDER into --out; runs nothing"},
        HEADING("other programs"),
        {.name = "export-cases",
         .kind = OPTION_TEXT,
         .out = &args.export_to,
         .value = "FOLDER",
         .help = "write the inputs of the cases as files, for another program; runs nothing"},
        {.name = "case",
         .kind = OPTION_TEXT,
         .out = &args.case_file,
         .value = "FILE",
         .help = "run the cases of this file only, in the format of a bundle's cases/"},
        HEADING("single backend (osteon validate starts such processes)"),
        {.name = "worker",
         .kind = OPTION_TEXT,
         .out = &args.worker,
         .value = "BACKEND",
         .help = "run the cases on this backend only, write --trace and compare nothing"},
        {.name = "trace",
         .kind = OPTION_OUTPUT,
         .out = &args.trace,
         .value = "FILE",
         .help = "file for the results of --worker"},
        {.name = "given",
         .kind = OPTION_TEXT,
         .out = &args.given,
         .value = "FILE",
         .help = "the reference's trace, from which every stage of --worker takes its input"},
        {.name = "dump",
         .kind = OPTION_TEXT,
         .out = &args.dump,
         .value = "FOLDER",
         .help = "write the results of --worker as a dump for osteon compare; --trace is not needed"},
        {.name = "user",
         .kind = OPTION_FLAG,
         .out = &args.from_parent,
         .help = "--worker receives the cases of --ct, --tool and --path from its parent process"},
        {.name = "from",
         .kind = OPTION_INTEGER,
         .out = &args.from,
         .value = "N",
         .min = 0,
         .max = 1000000,
         .help = "first case of --worker, counted from 0"},
        {.name = "to",
         .kind = OPTION_INTEGER,
         .out = &args.to,
         .value = "N",
         .min = 0,
         .max = 1000000,
         .help = "case before which --worker ends (default: none)"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--tier TIER] [--ct FILE] [--tool FILE] [--path FILE] [options]",
        .about = "Runs generated cases, and cases of your own files, on every backend, and compares\n"
                 "every stage with the scalar reference, byte by byte. Each backend runs in its own\n"
                 "process.",

        .options = options,
        .notes = "Your own files become the cases user/1, user/2, ..., which run after those of the\n"
                 "tier; with --only user, only these cases run. The bundle contains the sizes and\n"
                 "SHA-256 of your files, but neither their names nor their content.\n"
                 "\n"
                 "The method is backend equivalence verification (code verification): it shows that\n"
                 "all backends compute the same results. It is not a clinical validation.",
        .example = "  osteon validate --out bundle\n  osteon validate --tier standard --cpu-only --json\n"
                   "  osteon validate --backends 'cpu:isa=avx2,threads=7;cl' --only session\n"
                   "  osteon validate --ct shoulder.nii.gz --tool reamer.stl --path motion.csv --out bundle\n"
                   "  osteon validate --tier full --shard 2/8 --out shards/2\n"
                   "  osteon validate --merge shards --out bundle",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = validate_check(app, &args, err)) != OST_OK)
        return status;
    return args.faults_only ? validate_faults(app, &args, err) : validate_task(app, &args, argc, argv, err);
}
