/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Uses the user's own files as cases of a campaign. Each CT forms one case together with all tools and paths. If
 * there is no CT, the tools form one case.
 *
 *   --ct, --tool, --path  --user_files_read--> user_store (integers), record
 *   record, the files again --user_files_again--> user_store          osteon verify --rerun
 *
 * All files are read and checked before any case is run. For each file, the record in the bundle contains the size, the
 * SHA-256, the options with which the file was read, and the results of reading it. The record never contains the
 * file's name.
 */
#ifndef OST_APP_VALIDATE_USER_FILES_H
#define OST_APP_VALIDATE_USER_FILES_H

#include "app/input/load.h"
#include "app/input/ream_path.h"
#include "app/input/removal_options.h"
#include "validation/user_store.h"

typedef struct user_files {
    option_list cts, tools, paths;
    ct_options ct;
    tool_options how;
    target_options target;
    option_decimal rate;
    int sweep; /* index in "off|on" */
} user_files;

#define USER_FILES_DEFAULT {.ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT, .sweep = 1}

/* The rows of the options for the user's files in a verb's option table. */
#define USER_FILES(u, about_ct, about_tool, about_path)                                                \
    {.name = "ct", .kind = OPTION_LIST, .out = &(u).cts, .value = "FILE", .help = about_ct},           \
    {.name = "tool", .kind = OPTION_LIST, .out = &(u).tools, .value = "FILE", .help = about_tool},     \
    {.name = "path", .kind = OPTION_LIST, .out = &(u).paths, .value = "FILE", .help = about_path}

/*
 * Rows for a verb's table of options. These options determine how the files are read, and are the same as those of
 * import, voxelize and ream.
 */
#define USER_FILES_HOW(u)                                                                                              \
    CT_OPTIONS((u).ct), TOOL_OPTIONS((u).how),                                                                         \
        TARGET_OPTIONS((u).target, "centre of the glenoid's face, for the built-in paths (default: as in the CT)"),    \
        RATE_OPTION((u).rate), SWEEP_OPTION((u).sweep)

bool user_files_given(const user_files *u);

/*
 * Returns those options of USER_FILES_HOW that a command line contains, for example ["--cubic=0.5"]. The options are in
 * the order of the table. The caller owns the result.
 */
json_t *user_files_how(int argc, char **argv);

/* Reads the files. `how` is the result of user_files_how. The caller owns *store and *record. */
ost_status user_files_read(const app_state *app, const user_files *u, json_t *how, user_store **store, json_t **record,
                           ost_error *err);

/* Reads the files that are named on the command line of a verb. If there are none, sets *store and *record to NULL. */
ost_status user_files_of(const app_state *app, const user_files *u, int argc, char **argv, user_store **store,
                         json_t **record, ost_error *err);

/*
 * Finds the files of a bundle's record among the given files, by size and digest. Reads these files with the options
 * in the record. *again is a new record of the files.
 */
ost_status user_files_again(app_state *app, const user_files *given, const json_t *record, user_store **store,
                            json_t **again, ost_error *err);

#endif
