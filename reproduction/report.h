/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes report.html: all results of a run, or of several merged runs, on one page that loads no other file and can
 * be printed on A4.
 *
 *   summary     machines; statements of the thesis with a verdict and its reason
 *   items       table with the values of this run and of the thesis, plots, pictures, remarks
 *   list        every table and figure of the thesis: reproduced, not part of this run, or missing with the reason
 */
#ifndef OST_REPRODUCTION_REPORT_H
#define OST_REPRODUCTION_REPORT_H

#include "reproduction/item.h"

/* The outcome of an item. */
typedef struct report_entry {
    const reproduction_item *item;
    const result *result;              /* NULL if the item was not run or failed */
    char reason[OST_ERROR_TEXT];       /* reason for a failure; "" if the item did not fail */
} report_entry;

/* Writes FOLDER/report.html. The entries are in the order of the thesis. */
ost_status reproduction_report(const char *folder, const report_entry *entries, size_t count, ost_error *err);

#endif
