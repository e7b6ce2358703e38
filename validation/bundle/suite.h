/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The results of the test suite in a bundle (osteon validate --with-suite):
 *
 *   requirements.csv --suite_tests--> paths of tests --suite_run--> suite.json
 *
 * suite.json has one object for each test that a requirement names, sorted by
 * path: result, exit status, seconds, and size and SHA-256 of its output.  The
 * result follows from the status as in automake's harness: 0 is passed, 77 is
 * skipped, any other status is failed.  A test that was stopped is failed, too.
 * protocol.json states that the suite is to be run, so that a missing file is
 * detected.
 */
#ifndef OST_VALIDATION_BUNDLE_SUITE_H
#define OST_VALIDATION_BUNDLE_SUITE_H

#include <jansson.h>

#include "validation/bundle/bundle.h"

#define SUITE_FILE "suite.json"

/* Exit status of a skipped test, as in automake. If a signal ended the test, its status is the negative signal
   number. */
enum { SUITE_SKIPPED = 77, SUITE_REASON = 200 };
/* Maximum number of bytes of a test's output; a test that prints more is stopped. */
#define SUITE_OUTPUT_MAX ((json_int_t)64 << 20)

/* Returns the tests that the rows of requirements.csv name, sorted, without duplicates; owned by the caller; NULL if
   memory is exhausted. */
json_t *suite_tests(const char *requirements);

/* Returns "passed", "skipped" or "failed". The parameter stopped is the reason why the test was stopped; it is "" if
   the test was not stopped. */
const char *suite_result(json_int_t status, const char *stopped);

/* Counts the elements of o's array "tests" that are passed, skipped and failed, and writes these counts into o. */
void suite_count(json_t *o);

/* Reports every part of a bundle's suite.json that does not follow from the protocol, from requirements.csv or from the
   other parts of suite.json. */
ost_status suite_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                       ost_error *err);

#endif
