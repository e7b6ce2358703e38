/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a campaign leaves, as files that follow from two:
 *
 *   protocol.json  what was to be done, frozen before it was done
 *   cases.jsonl    a line a case: its input's digest, the digests of all that
 *                  the reference made, and of each backend the digest of what
 *                  that backend made and the verdict that follows (judge.h)
 *       |
 *       '--evidence_write--> results.json, results.tap, inputs.csv, anomalies.csv,
 *                            margins.csv, deviations.csv, README.md
 *
 * Since the rest is derived, whoever checks a bundle derives it again and
 * compares bytes; and bundles of shards are merged by putting their cases in
 * the protocol's order.
 */
#ifndef OST_VALIDATION_EVIDENCE_H
#define OST_VALIDATION_EVIDENCE_H

#include <jansson.h>

#include "validation/campaign.h"

#define EVIDENCE_PROTOCOL "protocol.json"
#define EVIDENCE_CASES "cases.jsonl"
enum { EVIDENCE_FORMAT = 2 }; /* of a bundle: 1 had words in place of the backends' digests */

/* Both give the caller's reference. chosen: the backends that were asked for, "" for all that are here. */
ost_status evidence_protocol(const plan *p, const subject_list *subjects, const char *chosen, bool cpu_only, json_t **out, ost_error *err);
/* One case's line but for its results, while its batch is there (campaign_options.done). */
ost_status evidence_case(const campaign *c, int case_index, json_t **out, ost_error *err);
/* The results, into the lines of all cases in the plan's order. */
ost_status evidence_results(const campaign *c, json_t *cases, ost_error *err);

/* The digests of a case's records, as its line has them; the caller's reference, NULL on failure. */
ost_status evidence_records(const trace *t, compare_range range, json_t **out, ost_error *err);

/* The reference refused this case's input at some stage: whoever refuses it as well is equal, and nothing was shown. */
bool evidence_refused(const json_t *one);

/*
 * {verdict, equal, evidence, cases, backends, compared, refused, ... }: the
 * verdict and the counts behind it.
 *
 *   EQUAL         every result is the reference's, and there is one of a case that the reference did not refuse
 *   NOT EQUAL     one is not
 *   NOT COMPARED  there is none: no backend, or all cases were refused or not run
 *   NOT COMPLETE  none differs, but cases of the protocol are missing
 *
 * equal is true for the first alone.  evidence is false for a tier or a choice
 * of backends that shows too little; not_shown says what, in sentences.
 */
ost_status evidence_summary(const json_t *protocol, const json_t *cases, json_t **out, ost_error *err);

/* One result as cases.jsonl has it: verdict, place, both values, class, hint, operands, margins; the caller's reference. */
json_t *evidence_result(const case_result *r);

/* The text under a key of an object; "" where there is none. */
const char *evidence_text(const json_t *o, const char *key);

/*
 * Returns part `number` of a file that has the key in each run: the file itself as part 0, or each value of merged shards.
 * Returns NULL behind the last part.
 */
const json_t *evidence_part(const json_t *file, const char *key, size_t number);

/*
 * What a command needs for the user's own cases, " --ct FILE --tool FILE --cubic=0.5": the files' names are not known.
 * how: also how they are read, for osteon validate.  "" where there are none; free() it; NULL without memory.
 */
char *evidence_own_options(const json_t *protocol, bool how);

/* "tick 12: 3 voxels differ, the first at (1, 2, 3): 5 where the reference has 0" */
enum { EVIDENCE_DESCRIPTION = 400 };
void evidence_describe(const json_t *result, char text[EVIDENCE_DESCRIPTION]);

/* Returns why a result is no comparison, for test harnesses: not run, or refused by the reference too; NULL when it is one. */
const char *evidence_skipped(const json_t *one, const json_t *result, const json_t *backend);

/* A test harness takes a list without a failure for a success: a campaign that compared nothing fails a line of its own. */
#define EVIDENCE_NOTHING "nothing was compared with the reference"

typedef ost_status evidence_sink(void *user, const char *name, const void *bytes, size_t size, ost_error *err);
ost_status evidence_write(const json_t *protocol, const json_t *cases, evidence_sink *sink, void *user, ost_error *err);

/* -------------------------------------------------- reading: evidence_read.c */

/* OST_ERR_INPUT in one line when protocol.json is of a bundle of another format than EVIDENCE_FORMAT. */
ost_status evidence_check_format(const char *folder, const json_t *protocol, ost_error *err);

/*
 * Reads cases.jsonl line by line within the limits of limits.h; OST_ERR_INPUT
 * names the line. Without keep_leaves the digests of leaves are left out, which
 * are most of it, and each line must be written as this program writes it.
 */
ost_status evidence_read_cases(const char *folder, bool keep_leaves, json_t **out, ost_error *err);

/* Reads both files of a bundle of this format, with all leaves; the caller's references. */
ost_status evidence_read(const char *folder, json_t **protocol, json_t **cases, ost_error *err);

#endif
