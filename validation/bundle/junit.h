/* SPDX-License-Identifier: Apache-2.0 */
/*
 * junit.xml: the verdicts as a test harness takes them, a suite a backend, with
 * the seconds of each case, the time of day and the host of the run. These are
 * of times.json and environment.json, so that the file varies from run to run.
 */
#ifndef OST_VALIDATION_JUNIT_H
#define OST_VALIDATION_JUNIT_H

#include "validation/bundle/evidence.h"

#define JUNIT_FILE "junit.xml"

/* times, environment: of one run, or of merged shards {"1/2": ...}; either may be NULL. */
ost_status junit_write(const json_t *protocol, const json_t *cases, const json_t *times, const json_t *environment,
                       evidence_sink *sink, void *user, ost_error *err);

#endif
