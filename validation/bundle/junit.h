/* SPDX-License-Identifier: Apache-2.0 */
/*
 * junit.xml: the verdicts in the format of test harnesses, with a suite per
 * backend, the seconds of each case, and the time of day and the host of the run.
 * The times and the host come from times.json and environment.json, so junit.xml
 * differs from run to run.
 */
#ifndef OST_VALIDATION_JUNIT_H
#define OST_VALIDATION_JUNIT_H

#include "validation/bundle/evidence.h"

#define JUNIT_FILE "junit.xml"

/* Writes junit.xml. The parameters times and environment are the objects of one run or, for merged shards, {"1/2":
   object, ...}; each of them may be NULL. */
ost_status junit_write(const json_t *protocol, const json_t *cases, const json_t *times, const json_t *environment,
                       evidence_sink *sink, void *user, ost_error *err);

#endif
