/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The results of the test suite in a bundle (osteon validate --with-suite):
 *
 *   requirements.csv --suite_tests--> paths of tests --suite_run--> suite.json
 *
 * suite.json has one object for each test that a requirement names, sorted by
 * path: result, exit status, seconds, and size and SHA-256 of its output.  The
 * result follows from the status as in automake's harness: 0 is passed, 77 is
 * skipped, anything else, and a test that was stopped, is failed.  protocol.json
 * states that the suite is to be run, so that a missing file is detected.
 */
#ifndef OST_VALIDATION_BUNDLE_SUITE_H
#define OST_VALIDATION_BUNDLE_SUITE_H

#include <jansson.h>

#include "validation/bundle/bundle.h"

#define SUITE_FILE "suite.json"

/* Exit status for "skipped", that of automake. The status of a test that a signal ended is the negative signal
   number. */
enum { SUITE_SKIPPED = 77, SUITE_REASON = 200 };
/* Maximum number of bytes of a test's output; a test that prints more is stopped. */
#define SUITE_OUTPUT_MAX ((json_int_t)64 << 20)

/* Returns the tests that the rows of requirements.csv name, sorted, without duplicates; owned by the caller; NULL if
   memory is exhausted. */
json_t *suite_tests(const char *requirements);

/* Returns "passed", "skipped" or "failed". stopped: "", or the reason why the test was stopped. */
const char *suite_result(json_int_t status, const char *stopped);

/* Writes the counts "passed", "skipped" and "failed" of o's array "tests" into o. */
void suite_count(json_t *o);

/* Reports all parts of a bundle's suite.json that do not follow from its protocol, its requirements.csv or the file
   itself. */
ost_status suite_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                       ost_error *err);

#endif
