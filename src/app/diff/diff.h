/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon diff`.
 *
 *   cmd_diff.c   parses the options
 *   grids.c      loads and compares two grids (compare.h)
 *   report.c     reports the differences of two grids
 *   bundles.c    compares two bundles
 */
#ifndef OST_APP_DIFF_DIFF_H
#define OST_APP_DIFF_DIFF_H

#include "app/diff/compare.h"

typedef struct diff_args {
    const char *name_a, *name_b, *html;
    int64_t limit; /* number of voxels to print */
    int chunk;     /* index of the edge length of the chunks in "16|32|64" */
} diff_args;

/* Compares the grids, reports the result and writes the page of --html. Returns OST_ERR_DIFFER if the grids differ. */
ost_status diff_grids(const app_state *app, const diff_args *args, ost_error *err);
/* Prints and stores the result of a comparison, and the header facts that differ. */
void diff_report(const app_state *app, const diff_args *args, const loaded_volume *a, const loaded_volume *b,
                 const diff_result *r);

#endif
