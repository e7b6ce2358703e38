/* SPDX-License-Identifier: Apache-2.0 */
/* Implements `osteon verify`: checks that a bundle of evidence is intact and consistent. The
   machine that made the bundle is not needed. */
#include <sys/stat.h>

#include "app/validate/verify.h"

ost_status cmd_verify(app_state *app, int argc, char **argv, ost_error *err)
{
    verify_args args = {.own = USER_FILES_DEFAULT};
    const operand operands[] = {{"BUNDLE", &args.folder, "no bundle given"}, {NULL, NULL, NULL}};
    const char *const by_default = app->backend;
    const option options[] = {
        {.name = "trust",
         .kind = OPTION_LIST,
         .out = &args.trust,
         .value = "KEYS",
         .help = "verify the signatures with these public keys: a PEM file, or a folder of *.pem; may repeat"},
        {.name = "timestamp-ca",
         .kind = OPTION_TEXT,
         .out = &args.authority,
         .value = "FILE",
         .help = "with --trust: certificates (PEM) of the time-stamping authority; every signature must then have "
                 "a time stamp"},
        {.name = "rerun",
         .kind = OPTION_FLAG,
         .out = &args.rerun,
         .help = "run the cases again on the reference here and compare"},
        USER_FILES(args.own, "for --rerun: a CT of the bundle's cases user/1, user/2, ...; may repeat",
                   "a mesh of these cases; may repeat", "a path of these cases; may repeat"),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "BUNDLE [--trust KEYS] [--rerun [--backend BACKEND]] [options]",
        .about = "Checks a bundle that osteon validate wrote, without a network, a device or the\n"
                 "machine that wrote it:\n"
                 "  files      every file is the one in the manifest; none is missing, added, a\n"
                 "             link, a pipe or too large; the log's chain and lines are intact\n"
                 "  plan       protocol and cases follow from tier, seed and options\n"
                 "  verdicts   each follows from the digests of the reference's and the backend's\n"
                 "             results\n"
                 "  derived    results, tables, requirements, bill of materials and report follow\n"
                 "             from the other files\n"
                 "  digests    with --rerun: the cases are run again here, on the reference and,\n"
                 "             if it is given, on the backend of --backend\n"
                 "  signatures with --trust: there is at least one, and each (osteon sign) is by\n"
                 "             one of these keys; otherwise signatures are not verified\n"
                 "Cases of a user's own files are run again from these files, which are recognized\n"
                 "by their SHA-256; their order does not matter.\n"
                 "Exit status 1: the bundle was changed after it was written. 2: a file is missing\n"
                 "or cannot be read, so there is no verdict.",
        .operands = operands,
        .options = options,
        .example = "  osteon validate --out bundle\n  osteon verify bundle --rerun\n  osteon verify bundle --trust "
                   "reviewers.pem",
    };
    ost_status status;
    struct stat info;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    args.backend = app->backend != by_default ? app->backend : NULL;
    if (!args.rerun && user_files_given(&args.own))
        return usage_error(app, err, "--ct, --tool and --path need --rerun");
    if (args.authority && !args.trust.count)
        return usage_error(app, err, "--timestamp-ca needs --trust");
    if (!args.rerun && args.backend)
        return usage_error(app, err, "--backend needs --rerun");
    if (stat(args.folder, &info) != 0 || !S_ISDIR(info.st_mode))
        return ost_fail(err, OST_ERR_INPUT, "%s: not a folder; expected a bundle", args.folder);
    return verify_bundle(app, &args, err);
}
