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

/*
 * Writes one sentence: how many kinds were noticed of how many, that they are mistakes in the second
 * implementation and in no backend, and how many changed nothing.
 */
enum { FAULTS_STATEMENT = 240 };
void faults_statement(const sensitivity *s, char out[FAULTS_STATEMENT]);

/*
 * {injected, triggered, changed, detected, localized, survived, false_alarms, clean_runs, proved, statement, mistakes_in,
 *  kinds_total, kinds_changed, kinds_noticed, kinds_silent[], kinds[]}; the caller's reference.
 */
ost_status faults_json(const sensitivity *s, json_t **out, ost_error *err);

/* Every change was detected and located, there were some, and there was no false alarm. */
bool faults_proved(const sensitivity *s);

#endif
