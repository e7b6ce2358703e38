/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the suites of `osteon bench`, and prints and stores their rows. */
#ifndef OST_APP_BENCH_RUN_H
#define OST_APP_BENCH_RUN_H

#include "app/common/app.h"
#include "bench/bench.h"

/* Returns true if this build contains the suite. The name "all" stands for every suite. */
bool bench_suite_is_built(const char *suite);

/*
 * Runs the suite, or every suite if its name is "all". Each row is printed, in Markdown if `markdown` is true, and
 * added to the array "rows" of app->result. Returns OST_ERR_USAGE if no row matches the filter, OST_ERR_DIFFER if the
 * grid of a row differs from that of the reference, and OST_ERR_UNAVAILABLE if the backend is not available or no row
 * could run.
 */
ost_status bench_run_suites(app_state *app, const bench_options *options, const char *suite, bool markdown,
                            ost_error *err);

#endif
