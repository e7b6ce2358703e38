/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks the verdicts in cases.jsonl: derives each verdict again from the digests.
 *
 *   a line: the reference's records, each backend's digest --judge_case--> its verdicts, or contradictions
 *
 * Each backend's digest was made from that backend's own trace (digests.h). A verdict need not be trusted,
 * because it can be derived from these digests:
 *
 *   equal     the SHA-256 of the backend's lines equals that of the reference's lines
 *   differs   the backend's lines are present and have the stated SHA-256; the first line that differs
 *             from the reference's line gives the stage and the item
 *   failed    either the backend has no lines, or the conditions of `differs` hold and the backend's
 *             lines end with "failed" where the reference's lines continue
 *
 * A backend that crashed, exceeded its time limit or did not run has no complete result. A line that ends in
 * "-" represents a record that the backend lacks and is not compared. Such a line is accepted only if the
 * function may_lack allows it: a dump (dump.h) may lack any record, but cpu and ref may lack none.
 */
#ifndef OST_VALIDATION_JUDGE_H
#define OST_VALIDATION_JUDGE_H

#include <jansson.h>

enum { JUDGE_TEXT = 480 };
typedef void judge_problem(void *user, const char *text);

/* Reports every contradiction in the line of one case; the text contains the names of the case and the backend.
   `protocol` contains the list of backends. */
void judge_case(const json_t *protocol, const json_t *one, judge_problem *problem, void *user);

#endif
