/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes sensitivity.json. The file contains the counts for each kind of mistake, the sums of these counts, the number
 * of false alarms, and the seed, with which the run can be repeated.
 */
#ifndef OST_VALIDATION_FAULTS_H
#define OST_VALIDATION_FAULTS_H

#include <jansson.h>

#include "validation/sensitivity.h"

#define FAULTS_FILE "sensitivity.json"

/*
 * Writes a sentence that states how many kinds of mistakes there are, how many of them were detected and
 * how many changed no result. The sentence also states that the mistakes were made in the second
 * implementation and in no backend.
 */
enum { FAULTS_STATEMENT = 240 };
void faults_statement(const sensitivity *s, char out[FAULTS_STATEMENT]);

/*
 * Creates the content of sensitivity.json. The caller frees *out, which has these members:
 * {injected, triggered, changed, detected, localized, survived, not_detected, not_localized, false_alarms,
 *  clean_runs, proved, statement, mistakes_in, seed, first_problem,
 *  kinds_total, kinds_changed, kinds_noticed, kinds_silent[], kinds[]}.
 * The member first_problem is absent if there was no problem.
 */
ost_status faults_json(const sensitivity *s, json_t **out, ost_error *err);

/* Returns true if there was no false alarm, at least one result changed, and every change was detected and located. */
bool faults_proved(const sensitivity *s);

#endif
