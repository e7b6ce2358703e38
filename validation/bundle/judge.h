/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Derives the verdicts from the digests in cases.jsonl.
 *
 *   a line: the reference's records, each backend's digest --judge_case--> its verdicts, or contradictions
 *
 * Each backend's digest was made from that backend's own trace (digests.h), so
 * that a verdict is a comparison of two digests and not a statement to be trusted:
 *
 *   equal     the SHA-256 of the backend's lines equals that of the reference's lines
 *   differs   the backend's lines are present and have the stated SHA-256; the first line that differs
 *             from the reference's line gives the stage and the item
 *   failed    as for `differs`, and the backend's lines end with "failed" where those of the reference
 *             continue; or the backend has no lines
 *
 * A backend that crashed, exceeded its time limit or did not run has no complete result.
 * A line that ends in "-" stands for a record that the backend lacks and is not compared.
 * It is accepted only if may_lack allows it: a dump (dump.h) may lack any record, cpu and
 * ref may lack none.
 */
#ifndef OST_VALIDATION_JUDGE_H
#define OST_VALIDATION_JUDGE_H

#include <jansson.h>
#include <osteon/digest.h>

enum { JUDGE_TEXT = 480 };
typedef void judge_problem(void *user, const char *text);

/* Reports every contradiction in one case's line; the text names the case and the backend. protocol lists the
   backends. */
void judge_case(const json_t *protocol, const json_t *one, judge_problem *problem, void *user);

/* Computes the SHA-256 of the lines of the reference's records. Returns false if the rows are not in the form of
   cases.jsonl. */
bool judge_reference(const json_t *one, ost_digest *out);

#endif
