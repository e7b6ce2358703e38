/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sensitivity.json: the catalogue of mistakes with counts for each, their
 * sums, false alarms, and what makes the run again.
 */
#ifndef OST_VALIDATION_FAULTS_H
#define OST_VALIDATION_FAULTS_H

#include <jansson.h>

#include "validation/sensitivity.h"

#define FAULTS_FILE "sensitivity.json"

/* {injected, triggered, changed, detected, localized, survived, false_alarms, clean_runs, proved, kinds[]}; the caller's reference. */
ost_status faults_json(const sensitivity *s, json_t **out, ost_error *err);

/* Every change was detected and located, there were some, and there was no false alarm. */
bool faults_proved(const sensitivity *s);

#endif
