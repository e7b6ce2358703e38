/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sensitivity.json: the catalogue of mistakes with counts for each, their
 * sums, the false alarms, and the command that repeats the run.
 */
#ifndef OST_VALIDATION_FAULTS_H
#define OST_VALIDATION_FAULTS_H

#include <jansson.h>

#include "validation/sensitivity.h"

#define FAULTS_FILE "sensitivity.json"

/*
 * Writes a sentence that states how many kinds of mistakes there are, how many of them were detected and how
 * many changed nothing, and that the mistakes were made in the second implementation and in no backend.
 */
enum { FAULTS_STATEMENT = 240 };
void faults_statement(const sensitivity *s, char out[FAULTS_STATEMENT]);

/*
 * Makes the content of sensitivity.json, owned by the caller:
 * {injected, triggered, changed, detected, localized, survived, false_alarms, clean_runs, proved,
 * statement, mistakes_in,
 *  kinds_total, kinds_changed, kinds_noticed, kinds_silent[], kinds[]}.
 */
ost_status faults_json(const sensitivity *s, json_t **out, ost_error *err);

/* Returns true if at least one result was changed, every change was detected and located, and there was no false
   alarm. */
bool faults_proved(const sensitivity *s);

#endif
