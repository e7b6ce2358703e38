/* SPDX-License-Identifier: Apache-2.0 */
/* Implements `osteon sign`: signs a bundle that `osteon verify` accepts. */
#include <sys/stat.h>

#include "app/common/options.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "validation/bundle/check.h"
#include "validation/bundle/sign.h"

static void print_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem)
{
    (void)kind;
    print_line(user, "  %s %s", file, problem);
}

/*
 * Checks the bundle and its existing signatures as `osteon verify` does. A bundle that `osteon verify` rejects must not
 * be signed. The error is printed here, because OST_ERR_DIFFER prints no message.
 */
static ost_status check_first(app_state *app, const char *folder, json_t **summary, ost_error *err)
{
    json_t *signatures = NULL;
    int found = 0;
    ost_status status = check_bundle(folder, print_problem, app, &found, summary, err);
    if (status == OST_OK)
        status = sign_check(folder, NULL, print_problem, app, &found, &signatures, err);
    json_decref(signatures);
    if (status == OST_OK && found) {
        print_line(app, "%s: not signed, because the bundle was changed after it was written", folder);
        status = ost_fail(err, OST_ERR_DIFFER, "%s: not signed, because the bundle was changed after it was written",
                          folder);
    }
    return status;
}

ost_status cmd_sign(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *folder = NULL, *key_file = NULL, *passphrase = NULL, *by = "", *meaning = NULL;
    const operand operands[] = {{"BUNDLE", &folder, "no bundle given"}, {NULL, NULL, NULL}};
    const option options[] = {
        {.name = "key", .kind = OPTION_TEXT, .out = &key_file, .value = "FILE", .required = true,
         .help = "private key in PEM: Ed25519 or ECDSA P-256"},
        {.name = "meaning", .kind = OPTION_TEXT, .out = &meaning, .value = "TEXT", .required = true,
         .help = "meaning of the signature, such as \"reviewed and accepted\""},
        {.name = "by", .kind = OPTION_TEXT, .out = &by, .value = "NAME",
         .help = "printed name of the signer (default: none)"},
        {.name = "passphrase-file", .kind = OPTION_TEXT, .out = &passphrase, .value = "FILE",
         .help = "file whose first line is the passphrase of the key (default: OpenSSL prompts on the terminal)"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "BUNDLE --key FILE --meaning TEXT [--by NAME] [--passphrase-file FILE]",
        .about = "Signs a bundle that osteon validate wrote, after the checks of osteon verify.\n"
                 "The signature is a file in the bundle's folder signatures/: a DSSE envelope\n"
                 "around an in-toto statement (test-result v0.1) that names manifest.json, and\n"
                 "through it every other file, by SHA-256. A bundle may have several signatures,\n"
                 "such as the tester's and the reviewer's. Name, meaning and time are the signer's\n"
                 "claims; the signature binds them to the bundle. The time is from this machine's\n"
                 "clock.",
        .operands = operands,
        .options = options,
        .example = "  openssl genpkey -algorithm ed25519 -out reviewer.key\n"
                   "  openssl pkey -in reviewer.key -pubout -out reviewer.pem\n"
                   "  osteon sign bundle --key reviewer.key --by \"A. Reviewer\" --meaning accepted\n"
                   "  osteon verify bundle --trust reviewer.pem",
    };
    ost_status status;
    struct stat info;
    sign_key *key = NULL;
    json_t *summary = NULL;
    char name[SIGN_NAME];
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
        return ost_fail(err, OST_ERR_INPUT, "%s: not a folder; expected a bundle", folder);
    status = sign_key_open(key_file, passphrase, &key, err);
    if (status == OST_OK)
        status = check_first(app, folder, &summary, err);
    if (status == OST_OK)
        status = sign_bundle(folder, key, by, meaning, name, err);
    if (status == OST_OK) {
        print_line(app, "%s/%s: signs the verdict %s", folder, name,
                   json_string_value(json_object_get(summary, "verdict")));
        put_text(app->result, "bundle", folder);
        put_text(app->result, "signature", name);
        put_text(app->result, "verdict", json_string_value(json_object_get(summary, "verdict")));
    }
    json_decref(summary);
    sign_key_free(key);
    return status;
}
