/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The evidence of a campaign. All of its files are derived from two:
 *
 *   protocol.json  what is to be run, written before anything ran
 *   cases.jsonl    a line per case: its input's digest, the digests of all results
 *                  of the reference, and for each backend the digest of its
 *                  results and the verdict that follows (judge.h)
 *       |
 *       '--evidence_write--> results.json, results.tap, inputs.csv, anomalies.csv,
 *                            margins.csv, deviations.csv, README.md
 *
 * A check of a bundle therefore derives the other files again and compares
 * bytes; and bundles of shards are merged by putting their cases in the
 * protocol's order.
 */
#ifndef OST_VALIDATION_EVIDENCE_H
#define OST_VALIDATION_EVIDENCE_H

#include <jansson.h>

#include "validation/campaign.h"

#define EVIDENCE_PROTOCOL "protocol.json"
#define EVIDENCE_CASES "cases.jsonl"
/* version of the bundle's format; in version 1 a word such as "equal" was in place of each backend's digest */
enum { EVIDENCE_FORMAT = 2 };

/* Makes protocol.json; the caller owns *out. chosen: the requested backends, "" for all available ones. */
ost_status evidence_protocol(const plan *p, const subject_list *subjects, const char *chosen, bool cpu_only,
                             json_t **out, ost_error *err);
/* Makes the line of one case without its results. Called while the case's batch is open (campaign_options.done). */
ost_status evidence_case(const campaign *c, int case_index, json_t **out, ost_error *err);
/* Adds the results to the lines of all cases. The lines must be in the plan's order. */
ost_status evidence_results(const campaign *c, json_t *cases, ost_error *err);

/* Makes the digests of a case's records in the form in which the case's line stores them. The caller owns *out,
   which is NULL on failure. */
ost_status evidence_records(const trace *t, compare_range range, json_t **out, ost_error *err);

/* Returns true if the reference refused this case's input at some stage. A backend that also refuses the input is
   equal, but this result is no evidence. */
bool evidence_refused(const json_t *one);

/*
 * Computes the verdict of a campaign and the counts from which it follows:
 * {verdict, equal, evidence, cases, backends, compared, refused, ... }.
 *
 *   EQUAL         every result is the reference's, and at least one is of a case that the reference did not refuse
 *   NOT EQUAL     at least one result differs
 *   NOT COMPARED  there are no results: no backend, or all cases were refused or not run
 *   NOT COMPLETE  no result differs, but cases of the protocol are missing
 *
 * equal is true only for EQUAL.  evidence is false if the tier or the choice of
 * backends covers too little; not_shown states in sentences what is not covered.
 */
ost_status evidence_summary(const json_t *protocol, const json_t *cases, json_t **out, ost_error *err);

/* Makes one result as in cases.jsonl: verdict, position, both values, class, hint, operands, margins; owned by the
   caller. */
json_t *evidence_result(const case_result *r);

/* Returns the text that an object has under a key; "" if there is none. */
const char *evidence_text(const json_t *o, const char *key);

/*
 * Returns part `number` of a file, or NULL after the last part. A file that contains the key itself
 * comes from one run and is its own part 0. Any other file comes from merged shards, and its values
 * are the parts.
 */
const json_t *evidence_part(const json_t *file, const char *key, size_t number);

/*
 * Returns the options that a command needs for the user's own cases, such as " --ct FILE --tool
 * FILE --cubic=0.5". The names of the files are not recorded. If how is true, the text includes the
 * options by which osteon validate reads the files. Returns "" if there are no such cases, NULL if
 * memory is exhausted. The caller frees the text with free().
 */
char *evidence_own_options(const json_t *protocol, bool how);

/* Writes a result as text: "tick 12: 3 voxels differ, the first at (1, 2, 3): 5 where the reference has 0". */
enum { EVIDENCE_DESCRIPTION = 400 };
void evidence_describe(const json_t *result, char text[EVIDENCE_DESCRIPTION]);

/* Returns the reason why a result is not a comparison, for test harnesses: the backend did not run, or the reference
   and the backend refused the input. Returns NULL if the result is a comparison. */
const char *evidence_skipped(const json_t *one, const json_t *result, const json_t *backend);

/* A test harness counts a list without failures as a success, so a campaign that compared nothing adds this failing
   line. */
#define EVIDENCE_NOTHING "nothing was compared with the reference"

typedef ost_status evidence_sink(void *user, const char *name, const void *bytes, size_t size, ost_error *err);
ost_status evidence_write(const json_t *protocol, const json_t *cases, evidence_sink *sink, void *user, ost_error *err);

/* -------------------------------------------------- reading: evidence_read.c */

/* Returns OST_ERR_INPUT, with a message of one line, if the format of protocol.json is not EVIDENCE_FORMAT. */
ost_status evidence_check_format(const char *folder, const json_t *protocol, ost_error *err);

/*
 * Reads cases.jsonl line by line within the limits of limits.h; the message of
 * OST_ERR_INPUT names the line.  Without with_leaves the digests of leaves, which
 * are the largest part, are omitted, and each line must be written as this
 * program writes it.
 */
ost_status evidence_read_cases(const char *folder, bool with_leaves, json_t **out, ost_error *err);

/* Reads protocol.json, which must have the format EVIDENCE_FORMAT, and cases.jsonl with the digests of all leaves. The
   caller owns both. */
ost_status evidence_read(const char *folder, json_t **protocol, json_t **cases, ost_error *err);

#endif
