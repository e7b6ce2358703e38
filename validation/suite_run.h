/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs the tests that are listed in requirements.csv, for osteon validate --with-suite.
 *
 *   FOLDER/tests/run-test PATH --exit status, output--> suite.json (bundle/suite.h)
 *
 * make writes tests/run-test into the build folder. Any folder that contains this program can be used as a
 * suite. Each test runs in its own process group, with /dev/null as its input. Its running time and the
 * size of its output are limited. Only the size, the SHA-256 and the last line of the output are recorded.
 */
#ifndef OST_VALIDATION_SUITE_RUN_H
#define OST_VALIDATION_SUITE_RUN_H

#include <jansson.h>
#include <osteon/status.h>

typedef struct suite_options {
    const char *folder, *requirements; /* requirements is the text of requirements.csv */
    int64_t limit_s;                   /* time limit of each test in seconds */
    int jobs;                          /* maximum number of concurrent tests */
    void (*show)(void *user, const char *what, double share);
    void *user;
} suite_options;

/* Returns OST_ERR_INPUT with an error line if the folder contains no program tests/run-test. */
ost_status suite_find(const char *folder, ost_error *err);

/* Runs the tests. Sets *out to the content of suite.json, which the caller owns. */
ost_status suite_run(const suite_options *o, json_t **out, ost_error *err);

#endif
