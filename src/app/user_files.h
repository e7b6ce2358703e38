/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The user's own files as cases of a campaign: each CT with all tools and
 * paths is one, and tools without a CT are one.
 *
 *   --ct, --tool, --path  --user_files_read--> user_store (integers), record
 *   record, the files again --user_files_again--> user_store          osteon verify --rerun
 *
 * Everything is read and checked before anything runs.  The record stands in
 * the bundle: of each file its size and SHA-256, never its name; how it was
 * read, as options; and what became of it.
 */
#ifndef OST_APP_USER_FILES_H
#define OST_APP_USER_FILES_H

#include "app/load.h"
#include "app/ream_path.h"
#include "validation/user_store.h"

typedef struct user_files {
    option_list cts, tools, paths;
    ct_options ct;
    tool_options how;
    target_options target;
    option_decimal rate;
    int sweep; /* place in "off|on" */
} user_files;

#define USER_FILES_DEFAULT {.ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT, .sweep = 1}

/* Rows for a verb's table of options: the files, */
#define USER_FILES(u, about_ct, about_tool, about_path)                                                \
    {.name = "ct", .kind = OPTION_LIST, .out = &(u).cts, .value = "FILE", .help = about_ct},           \
    {.name = "tool", .kind = OPTION_LIST, .out = &(u).tools, .value = "FILE", .help = about_tool},     \
    {.name = "path", .kind = OPTION_LIST, .out = &(u).paths, .value = "FILE", .help = about_path}

/* and how they are read, as import, voxelize and ream have it. */
#define USER_FILES_HOW(u)                                                                                                             \
    CT_OPTIONS((u).ct), TOOL_OPTIONS((u).how),                                                                                        \
    {.name = "at", .kind = OPTION_POINT, .out = &(u).target.at, .given = &(u).target.at_given, .value = "X,Y,Z",                      \
     .help = "centre of the glenoid's face, for built-in paths"},                                                                     \
    {.name = "axis", .kind = OPTION_VECTOR, .out = (u).target.axis, .given = &(u).target.axis_given, .value = "X,Y,Z",                \
     .help = "direction into the bone there"},                                                                                        \
    {.name = "side", .kind = OPTION_CHOICE, .out = &(u).target.side, .given = &(u).target.side_given, .value = "left|right",          \
     .help = "of the body (default: the file's, else the axis determines it)"},                                                                        \
    {.name = "rate", .kind = OPTION_DECIMAL, .out = &(u).rate, .value = "HZ", .help = "remove so many times a second (default: every tick)"}, \
    {.name = "sweep", .kind = OPTION_CHOICE, .out = &(u).sweep, .value = "off|on", .help = "fill in between two ticks (default: on)"}

bool user_files_given(const user_files *u);

/* The options of USER_FILES_HOW that stand on a command line, in the table's order: ["--cubic=0.5", ...]; the caller's reference. */
json_t *user_files_how(int argc, char **argv);

/* how: as above. Both results are the caller's. */
ost_status user_files_read(const app_state *app, const user_files *u, json_t *how, user_store **store, json_t **record, ost_error *err);

/* The same for a verb's command line; neither store nor record (NULL) where no file is given. */
ost_status user_files_of(const app_state *app, const user_files *u, int argc, char **argv, user_store **store, json_t **record, ost_error *err);

/* The files of a bundle's record, found among those given by size and digest, read as they were then; again: the record of that. */
ost_status user_files_again(app_state *app, const user_files *given, const json_t *record, user_store **store, json_t **again, ost_error *err);

#endif
