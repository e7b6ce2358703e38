/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The verdicts that follow from the digests in cases.jsonl.
 *
 *   a line: the reference's records, each backend's digest --judge_case--> its verdicts, or what they contradict
 *
 * Each backend's digest was made from that backend's own trace (digests.h), so
 * a verdict is a comparison of two digests and no word that somebody wrote:
 *
 *   equal     the SHA-256 of its lines is that of the reference's
 *   differs   its lines are there, give its SHA-256, and the first that is not the reference's is the stage and item of the verdict
 *   failed    the same, and its lines end with "failed" where the reference's go on; or it has none
 *
 * A backend that crashed, was late or did not run made nothing complete.  A line
 * that says "-" is compared with nothing; it is accepted where the backend may
 * lack the record: any of a dump (dump.h), none of cpu and ref (may_lack).
 */
#ifndef OST_VALIDATION_JUDGE_H
#define OST_VALIDATION_JUDGE_H

#include <jansson.h>
#include <osteon/digest.h>

enum { JUDGE_TEXT = 480 };
typedef void judge_problem(void *user, const char *text);

/* Reports every contradiction of one case's line; the text names the case and the backend. protocol gives the backends. */
void judge_case(const json_t *protocol, const json_t *one, judge_problem *problem, void *user);

/* The SHA-256 of the lines of the reference's records; false where the rows have not the form of cases.jsonl. */
bool judge_reference(const json_t *one, ost_digest *out);

#endif
