/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The results of the test suite in a bundle (osteon validate --with-suite):
 *
 *   requirements.csv --suite_tests--> paths of tests --suite_run--> suite.json
 *
 * suite.json has one object for each test that is listed in requirements.csv, sorted by path. The object contains the
 * test's result, exit status and running time, and the size and SHA-256 of its output. The result follows from the
 * status as in automake's harness: 0 is passed, 77 is skipped, any other status is failed. A test that was stopped also
 * counts as failed. protocol.json records that the suite is part of the campaign, so that a missing file suite.json is
 * detected.
 */
#ifndef OST_VALIDATION_BUNDLE_SUITE_H
#define OST_VALIDATION_BUNDLE_SUITE_H

#include <jansson.h>

#include "validation/bundle/bundle.h"

#define SUITE_FILE "suite.json"

/* Exit status of a skipped test, as in automake. The status of a test that was ended by a signal is the negative
   signal number. */
enum { SUITE_SKIPPED = 77, SUITE_REASON = 200 };
/* maximum size of the output of a test in bytes; a test that exceeds it is stopped */
#define SUITE_OUTPUT_MAX ((json_int_t)64 << 20)

/* Returns the tests that are listed in requirements.csv, sorted and without duplicates. Returns NULL if memory is
   exhausted. The caller owns the result. */
json_t *suite_tests(const char *requirements);

/* Returns "passed", "skipped" or "failed". `stopped` is the reason why the test was stopped, or "" if the test ended by
   itself. */
const char *suite_result(json_int_t status, const char *stopped);

/* Counts the passed, skipped and failed tests in the array "tests" of o, and adds these counts to o. */
void suite_count(json_t *o);

/* Reports every part of a bundle's suite.json that contradicts the protocol, requirements.csv or another part of
   suite.json. */
ost_status suite_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                       ost_error *err);

#endif
