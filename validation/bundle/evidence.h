/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All files of a campaign's evidence are derived from two files:
 *
 *   protocol.json  the planned cases and backends, written before the first case runs
 *   cases.jsonl    a line per case: the digest of the input, the digests of all results of the reference,
 *                  and for each backend the digest of its results and the resulting verdict (judge.h)
 *       |
 *       '--evidence_write--> results.json, results.tap, inputs.csv, anomalies.csv,
 *                            margins.csv, deviations.csv, README.md
 *
 * Therefore a check of a bundle can derive the other files again and compare their bytes. The bundles of
 * shards are merged by sorting their cases into the protocol's order.
 */
#ifndef OST_VALIDATION_EVIDENCE_H
#define OST_VALIDATION_EVIDENCE_H

#include <jansson.h>

#include "validation/campaign.h"

#define EVIDENCE_PROTOCOL "protocol.json"
#define EVIDENCE_CASES "cases.jsonl"
/* version of the bundle's format; version 1 had a word such as "equal" in place of each backend's digest */
enum { EVIDENCE_FORMAT = 2 };

/* Makes protocol.json; the caller owns *out. `chosen` lists the requested backends and is "" if all available backends
   are used. */
ost_status evidence_protocol(const plan *p, const subject_list *subjects, const char *chosen, bool cpu_only,
                             json_t **out, ost_error *err);
/* Makes the line of one case, without its results. Must be called while the case's batch is open
   (campaign_options.done). */
ost_status evidence_case(const campaign *c, int case_index, json_t **out, ost_error *err);
/* Adds the results to the lines of all cases. The lines must be in the plan's order. */
ost_status evidence_results(const campaign *c, json_t *cases, ost_error *err);

/* Returns true if a stage of the reference refused this case's input. A backend that also refuses the input counts as
   equal, but this result is no evidence. */
bool evidence_refused(const json_t *one);

/*
 * Computes the verdict of a campaign and the counts from which the verdict follows:
 * {verdict, equal, evidence, cases, backends, compared, refused, ... }.
 *
 *   EQUAL         all results equal the reference's, and at least one is in a case that the reference did
 *                 not refuse
 *   NOT EQUAL     at least one result differs
 *   NOT COMPARED  there are no results, because there is no backend or all cases were refused or not run
 *   NOT COMPLETE  no result differs, but some cases of the protocol are missing
 *
 * The member `equal` is true only for EQUAL. The member `evidence` is false if the cases cover too little
 * (the tier is smoke, or only some of the tier's cases were run) or if nothing was compared. The sentences of
 * `not_shown` state what is not covered.
 */
ost_status evidence_summary(const json_t *protocol, const json_t *cases, json_t **out, ost_error *err);

/* Makes one result in the form of cases.jsonl: verdict, position, both values, class, hint, operands and margins. The
   caller owns it. */
json_t *evidence_result(const case_result *r);

/* Returns the string of member `key` of an object, or "" if there is none. */
const char *evidence_text(const json_t *o, const char *key);

/*
 * Returns part `number` of a JSON file, or NULL after the last part. The file of a single run has the member
 * `key` and is itself the only part. The file of merged shards has one part per shard.
 */
const json_t *evidence_part(const json_t *file, const char *key, size_t number);

/*
 * Returns the options that a command needs for the user's own cases, such as " --ct FILE --tool FILE --cubic=0.5". The
 * word FILE replaces the names of the files, which are not recorded. If `how` is true, the text includes the options
 * that determine how osteon validate reads the files. Returns "" if there are no such cases, NULL if memory is
 * exhausted. The caller frees the text with free().
 */
char *evidence_own_options(const json_t *protocol, bool how);

/* Describes a result in a string such as "tick 12: 3 voxels differ, the first at (1, 2, 3): 5 where the reference has
   0". */
enum { EVIDENCE_DESCRIPTION = 400 };
void evidence_describe(const json_t *result, char text[EVIDENCE_DESCRIPTION]);

/* Returns NULL if a result comes from a comparison. Otherwise, returns the reason for a test harness: either the
   backend did not run, or the reference and the backend refused the input. */
const char *evidence_skipped(const json_t *one, const json_t *result, const json_t *backend);

/* Name of a failing test that is added if a campaign compared nothing. Without a failing test, a test harness would
   report success. */
#define EVIDENCE_NOTHING "nothing was compared with the reference"

typedef ost_status evidence_sink(void *user, const char *name, const void *bytes, size_t size, ost_error *err);
ost_status evidence_write(const json_t *protocol, const json_t *cases, evidence_sink *sink, void *user, ost_error *err);

/* -------------------------------------------------- reading: evidence_read.c */

/* Returns OST_ERR_INPUT, with a message of one line, if the format of protocol.json is not EVIDENCE_FORMAT. */
ost_status evidence_check_format(const char *folder, const json_t *protocol, ost_error *err);

/*
 * Reads cases.jsonl line by line within the limits of limits.h. For OST_ERR_INPUT, the error line contains the line
 * number. If with_leaves is false, the digests of leaves (the largest part of the file) are omitted, and each line must
 * be identical to the text that this program writes.
 */
ost_status evidence_read_cases(const char *folder, bool with_leaves, json_t **out, ost_error *err);

/* Reads protocol.json and cases.jsonl with the digests of all leaves. The protocol must have the format
   EVIDENCE_FORMAT. The caller owns *protocol and *cases. */
ost_status evidence_read(const char *folder, json_t **protocol, json_t **cases, ost_error *err);

#endif
