/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon reproduce`.
 *
 *   cmd_reproduce.c   parses the options
 *   items.c           lists and selects the items
 *   run.c             measures or merges the items, and writes the report
 *   measure.c         measures items on this machine
 *   merge.c           merges the results of other runs (--merge)
 *   output.c          writes and reports the files of an item
 */
#ifndef OST_APP_REPRODUCE_REPRODUCE_H
#define OST_APP_REPRODUCE_REPRODUCE_H

#include "app/common/options.h"
#include "reproduction/report.h"
#include "reproduction/write.h"

enum { REPRODUCE_ITEMS_MAX = 64 };

typedef struct reproduce_args {
    const char *items, *out;
    bool quick, list;
    option_list merge, ct;
} reproduce_args;

/* The items of a run, in the order of the thesis. */
typedef struct reproduce_run {
    int count;
    report_entry entry[REPRODUCE_ITEMS_MAX];
    result results[REPRODUCE_ITEMS_MAX];
    int measured;
    char reason[OST_ERROR_TEXT]; /* reason for the first failure to measure an item */
} reproduce_run;

/* Prints the items, and the tables and figures that cannot be reproduced, and stores them in the result of the verb. */
void reproduce_list_items(app_state *app);
/* Selects the items in a list such as "table-3.3,figure-3.2". Selects all items if the text is "all" or NULL. */
ost_status reproduce_select_items(const app_state *app, const char *text, bool chosen[REPRODUCE_ITEMS_MAX],
                                  ost_error *err);

/*
 * Measures the chosen items or, with --merge, merges their results, and writes the report. Returns
 * OST_ERR_UNAVAILABLE if no item could be measured.
 */
ost_status reproduce_items(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                           ost_error *err);

/*
 * Measures the chosen items. If an item cannot be measured, the run contains the reason, and the next item is measured.
 */
ost_status reproduce_measure(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                             reproduce_run *run, ost_error *err);
/* Merges the chosen items of the folders of --merge. Returns OST_ERR_INPUT if the folders contain no result. */
ost_status reproduce_merge(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                           reproduce_run *run, ost_error *err);

/* Creates a folder. Returns OST_OK if the folder already exists. */
ost_status reproduce_make_folder(const char *folder, ost_error *err);
/* Prints and stores the result of an item and its files. If `r` is NULL, reports that the item was not measured. */
void reproduce_report_item(app_state *app, const char *id, const result *r, const write_files *files,
                           const char *reason);
/* Adds a measured or merged result to the run and writes its files. */
ost_status reproduce_finish_item(app_state *app, const reproduce_args *args, reproduce_run *run, report_entry *e,
                                 ost_error *err);

#endif
