/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Digests of a trace's records, for cases.jsonl.
 *
 *   {stage, item, sha256 of the body, leaves}
 *
 * leaves are AR-DIG-2's, of 32^3 voxels: all in order for a whole grid, and
 * [number, digest] for the leaves that a tick changed.  Two sites that
 * exchange these alone find the stage, the tick and the chunk that differ.
 *
 * The same digests without leaves are the lines of a case, one a record, made
 * from any backend's own trace; the SHA-256 of these lines stands for all that
 * the backend made of the case:
 *
 *   case 0 SHA-256 of the input\n
 *   rect 0 SHA-256 of the body\n
 *   ...
 *   tick 311 -\n        a dump (dump.h) has no such record
 *
 * A record of stage "failed" is digested without its text, since backends may
 * word a refusal differently.  Equal lines are equal records (compare.h).
 */
#ifndef OST_VALIDATION_DIGESTS_H
#define OST_VALIDATION_DIGESTS_H

#include <jansson.h>

#include "validation/compare.h"

/* bone: dims of the case's bone, for numbering a tick's leaves. */
ost_status digests_of_record(const trace_record *r, ost_dims bone, json_t **out, ost_error *err);

/* The lines of the records of a case; the caller frees *lines. *of_lines receives their SHA-256. */
ost_status digests_of_case(const trace *t, compare_range range, char **lines, ost_digest *of_lines, ost_error *err);

#endif
