/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon validate`: compares backends stage by stage and writes the evidence.
 *
 *   options --> a campaign, a merge of shards, or the sensitivity proof (validate.h)
 *
 * For each backend, the campaign starts the same verb with --worker. The worker runs cases on one
 * backend and writes a trace of all results.
 */
#include "app/validate/validate.h"

#include <stdlib.h>
#include <unistd.h>

#include "app/common/options.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "validation/bundle/impact.h"
#include "validation/dump/dump.h"
#include "validation/export.h"
#include "validation/locate/case_file.h"
#include "validation/scratch.h"
#include "validation/suite_run.h"
#include "validation/worker.h"

/* Reads a number of up to six digits. Returns the position after the number, or NULL if there is no digit. */
static const char *small_number(const char *at, int *out)
{
    const char *begin = at;
    for (*out = 0; *at >= '0' && *at <= '9' && at - begin < 6; at++)
        *out = 10 * *out + (*at - '0');
    return at > begin ? at : NULL;
}

/* Parses the value of --shard, such as "2/8". If the option is not given, the result is shard 1 of 1. */
static ost_status shard_of(const app_state *app, const char *text, int *shard, int *shards, ost_error *err)
{
    *shard = *shards = 1;
    if (!text)
        return OST_OK;
    const char *at = small_number(text, shard);
    at = at && *at == '/' ? small_number(at + 1, shards) : NULL;
    if (!at || *at || *shard < 1 || *shard > *shards)
        return usage_error(app, err, "--shard %s: must be I/N with 1 <= I <= N", text);
    return OST_OK;
}

/* Writes the results of one backend to a trace, and then converts the trace to the files of a dump. */
static ost_status dump_worker(const plan *p, const char *spec, const char *folder, ost_error *err)
{
    char path[SCRATCH_NAME];
    trace t = {0};
    int fd;
    ost_status status = scratch_file(&fd, err);
    if (status != OST_OK)
        return status;
    scratch_name(fd, path);
    status = worker_run(p, 0, p->count, spec, path, NULL, err);
    if (status == OST_OK)
        status = trace_open(path, &t, err);
    if (status == OST_OK)
        status = dump_write(folder, spec, p, &t, err);
    trace_free(&t);
    close(fd);
    return status;
}

ost_status cmd_validate(app_state *app, int argc, char **argv, ost_error *err)
{
    static const int64_t limits[PLAN_TIERS] = {120, 1800, 36000};
    enum { LIMIT_OWN = 36000 }; /* ten hours, because the user's own cases may take any length of time */
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
    plan p;
    int shard, shards;
    if (!options_parse(app, &usage, argc, argv, &status, err) ||
        (status = shard_of(app, args.shard, &shard, &shards, err)) != OST_OK)
        return status;
    if (!args.worker != !(args.trace || args.dump))
        return usage_error(app, err, args.worker ? "--worker needs --trace or --dump"
                                     : args.trace ? "--trace needs --worker" : "--dump needs --worker");
    if (args.trace && args.dump)
        return usage_error(app, err, "--trace cannot be combined with --dump");
    if (!args.worker && (args.from || args.to))
        return usage_error(app, err, "--from and --to need --worker");
    if (args.to && args.from > args.to)
        return usage_error(app, err, "--from %lld: must not be greater than --to %lld", (long long)args.from,
                           (long long)args.to);
    if (args.given && !args.trace)
        return usage_error(app, err, "--given needs --worker and --trace");
    if (args.export_to && (args.worker || args.out))
        return usage_error(app, err, "--export-cases cannot be combined with --worker or --out");
    if (args.cpu_only && args.backends)
        return usage_error(app, err, "--cpu-only cannot be combined with --backends");
    if (args.faults_only && args.out)
        return usage_error(app, err, "--faults-only cannot be combined with --out, because it writes no bundle");
    if (args.apart && (args.out || args.worker || args.merge || args.faults_only || args.export_to))
        return usage_error(app, err, "--apart cannot be combined with --out, --worker, --merge, --faults-only or "
                           "--export-cases: evidence needs complete runs");
    if (args.merge && (!args.out || args.worker || args.shard))
        return usage_error(app, err, "--merge needs --out, and cannot be combined with --shard or --worker");
    if ((args.merge || args.faults_only) && user_files_given(&args.own))
        return usage_error(app, err, "%s cannot be combined with --ct, --tool or --path",
                           args.merge ? "--merge" : "--faults-only");
    if (args.against && (!args.out || args.merge || args.faults_only))
        return usage_error(app, err, "--against needs --out, and cannot be combined with --merge or --faults-only");
    if (args.against && (status = impact_check(args.against, err)) != OST_OK)
        return status;
    if (args.suite && (!args.out || args.merge || args.faults_only || args.worker))
        return usage_error(app, err, "--with-suite needs --out, and cannot be combined with --merge, --faults-only or "
                           "--worker");
    if (args.suite && shard != 1)
        return usage_error(app, err, "--with-suite with --shard %s: only the first shard runs the tests; pass --shard "
                           "1/%d", args.shard, shards);
    if (args.suite && (status = suite_find(args.suite, err)) != OST_OK)
        return status;
    if ((args.sign && (!args.out || args.faults_only)) || (args.passphrase && !args.sign))
        return usage_error(app, err, args.sign ? "--sign needs --out" : "--passphrase-file needs --sign");
    if (args.faults && !args.faults_only)
        return usage_error(app, err, "--faults needs --faults-only");
    if (args.faults_only)
        return validate_faults(app, &args, err);
    if (args.case_file && !args.worker && (args.only || args.shard))
        return usage_error(app, err, "--case cannot be combined with --only or --shard");
    if (args.sign && (status = sign_key_open(args.sign, args.passphrase, &args.key, err)) != OST_OK)
        return status;
    if (args.merge) {
        status = validate_merge(app, &args, err);
        sign_key_free(args.key);
        return status;
    }
    user_store *store = NULL;
    json_t *from_file = NULL;
    status = args.from_parent ? user_store_open(WORKER_USER, &store, err)
                              : user_files_of(app, &args.own, argc, argv, &store, &args.record, err);
    const plan_user own = {.count = user_store_count(store), .store = store};
    if (!args.limit_s)
        args.limit_s = own.count ? LIMIT_OWN : limits[args.tier];
    if (status == OST_OK)
        status = args.case_file
                     ? case_file_read(args.case_file, own.count ? &own : NULL, &p, &from_file, err)
                     : plan_make((plan_tier)args.tier, (uint64_t)args.seed, shard, shards, args.only, &own, &p, err);
    if (status != OST_OK) {
        json_decref(args.record);
        sign_key_free(args.key);
        user_store_free(store);
        return status;
    }
    status = args.export_to ? export_cases(args.export_to, &p, err)
             : args.dump    ? dump_worker(&p, args.worker, args.dump, err)
             : args.worker  ? worker_run(&p, (int)args.from, args.to ? (int)args.to : p.count, args.worker, args.trace,
                                         args.given, err)
                            : validate_run(app, &args, &p, from_file, err);
    if (status == OST_OK && args.export_to) {
        print_line(app, "%s: inputs of %d case%s", args.export_to, p.count, p.count == 1 ? "" : "s");
        put_text(app->result, "out", args.export_to);
        put_integer(app->result, "cases", p.count);
    }
    plan_free(&p);
    json_decref(from_file);
    json_decref(args.record);
    sign_key_free(args.key);
    user_store_free(store);
    return status;
}
