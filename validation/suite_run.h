/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs the tests that requirements name, for osteon validate --with-suite.
 *
 *   FOLDER/tests/run-test PATH --exit status, output--> suite.json (bundle/suite.h)
 *
 * make writes tests/run-test into the build folder; any folder that has such a
 * program can be a suite.  Each test runs in a process group of its own, with
 * /dev/null as its input, for a limited time and with a limited output.  Of the
 * output only size, SHA-256 and last line are kept.
 */
#ifndef OST_VALIDATION_SUITE_RUN_H
#define OST_VALIDATION_SUITE_RUN_H

#include <jansson.h>
#include <osteon/status.h>

typedef struct suite_options {
    const char *folder, *requirements; /* requirements: the text of requirements.csv */
    int64_t limit_s;                   /* of each test */
    int jobs;                          /* tests that run at a time */
    void (*show)(void *user, const char *what, double share);
    void *user;
} suite_options;

/* Returns OST_ERR_INPUT, naming what is wrong, where the folder has no program tests/run-test. */
ost_status suite_find(const char *folder, ost_error *err);

/* *out receives suite.json's content; the caller's reference. */
ost_status suite_run(const suite_options *o, json_t **out, ost_error *err);

#endif
