/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts that all verbs of the command share.
 *
 *   main.c       finds the verb, prints its error, returns the exit status
 *   options.c    parses options and prints --help and messages, from one table per verb
 *   print.c      prints text and warnings for people, and formats numbers
 *   result.c     builds the JSON object of --json
 *   progress.c   prints a progress line on the terminal for work of more than a second
 *   input/load.c loads a bone or a tool from any supported file
 *   cmd_X.c      implements one verb
 *
 * A verb returns a status; main turns it into the exit status. A verb always fills its JSON object, so that runs with
 * and without --json do the same work.
 */
#ifndef OST_APP_COMMON_APP_H
#define OST_APP_COMMON_APP_H

#include <jansson.h>
#include <osteon/osteon.h>

typedef struct app_state {
    const char *verb;
    bool json, quiet;
    const char *backend; /* value of --backend; default "cpu" */
    int64_t threads;     /* value of --threads; 0 if the option is not given */
    /* true if a campaign started this process. The process then has a separate exit status for exhausted resources
       (validation/worker.h). */
    bool worker;
    bool to_stdout;      /* true if the output file is standard output, so that no line of text may be printed there */
    json_t *result;      /* JSON object of the verb's result; main owns it */
    /* Texts of all warnings so far, including those that --quiet suppresses. Owned by the function main. NULL if the
       verb does not record warnings. */
    json_t *warnings;
    /* True if `result` is complete although the verb returns an error; --json then prints the result before the error
     * message. */
    bool answered;
} app_state;

typedef struct app_verb {
    const char *name;
    const char *summary; /* one line of text for `osteon --help` */
    ost_status (*run)(app_state *app, int argc, char **argv, ost_error *err);
} app_verb;

ost_status cmd_bridge(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_compare(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_bench(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_devices(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_phantom(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_tool(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_import(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_segment(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_validate(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_sign(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_verify(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_voxelize(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_sim(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_render(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_reproduce(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_replay(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_ream(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_info(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_diff(app_state *app, int argc, char **argv, ost_error *err);
ost_status cmd_export(app_state *app, int argc, char **argv, ost_error *err);

#endif
