/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes junit.xml, which contains the verdicts in JUnit's format. There is one suite per
 * backend. The file also contains the running time of each case, and the time and the host of the run. The
 * times and the host come from times.json and environment.json, so junit.xml differs from run to run.
 */
#ifndef OST_VALIDATION_JUNIT_H
#define OST_VALIDATION_JUNIT_H

#include "validation/bundle/evidence.h"

#define JUNIT_FILE "junit.xml"

/* Writes junit.xml. In a bundle of one run, `times` and `environment` are the objects in times.json and
   environment.json. In a bundle of merged shards, they have the form {"1/2": object, ...}. Each of the two parameters
   may be NULL. */
ost_status junit_write(const json_t *protocol, const json_t *cases, const json_t *times, const json_t *environment,
                       evidence_sink *sink, void *user, ost_error *err);

#endif
