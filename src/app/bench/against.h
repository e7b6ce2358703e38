/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the rows of a run of `osteon bench` with those of an earlier run (--against).
 *
 *   FILE of --json --> rows by name --> ratio then / ratio now --> slower than allowed: exit status 1
 *
 * The runs are compared by a ratio: the baseline's shortest time divided by osteon's shortest time. The two are
 * measured alternately on the same machine, so the ratio depends little on the machine and on background load.
 */
#ifndef OST_APP_BENCH_AGAINST_H
#define OST_APP_BENCH_AGAINST_H

#include "app/common/app.h"
#include "app/common/options.h"
#include "bench/bench.h"

typedef struct bench_against {
    const char *path;   /* file with the results of the earlier run, or NULL */
    double limit;       /* maximum slowdown that is allowed, in percent */
    json_t *root, *rows; /* owned document of the earlier run, and the array of its rows within this document */
} bench_against;

/* Reads the earlier run, before anything is measured. `limit` is the text of --max-slowdown, "10" or "10%". */
ost_status bench_against_read(const app_state *app, const char *path, const char *limit, bool quick,
                              bench_against *out, ost_error *err);
void bench_against_free(bench_against *against);
/*
 * Compares the rows in app->result with the earlier run, prints them, and adds the object "against" to the result.
 * Returns OST_ERR_DIFFER if a row is slower than allowed, and OST_ERR_INPUT if no row can be compared.
 */
ost_status bench_against_compare(app_state *app, const bench_against *against, ost_error *err);

#endif
