/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes digests of a trace's records for cases.jsonl. The entry of one record is
 *
 *   {stage, item, sha256 of the body, leaves}
 *
 * The `leaves` member lists the digests of leaves of 32^3 voxels (AR-DIG-2). For a
 * complete grid it lists all leaves in order; for a tick it lists a pair [number,
 * digest] for each leaf that the tick changed. Two sites that exchange only these
 * digests can find the stage, the tick and the chunk that differ.
 *
 * The digest lines of a case contain one line per record: the stage, the item and the digest of the body. They
 * are computed from a backend's own trace. The SHA-256 of these lines identifies all results of the backend
 * in this case:
 *
 *   case 0 SHA-256 of the input\n
 *   rect 0 SHA-256 of the body\n
 *   ...
 *   tick 311 -\n        a dump (dump.h) has no such record
 *
 * The digest of a record of stage "failed" excludes the error text, because backends may report a refusal
 * in different words. If two lines are equal, compare.h finds no difference between their records,
 * except in bounds (trace_word_is_bound), which are not part of any digest.
 */
#ifndef OST_VALIDATION_DIGESTS_H
#define OST_VALIDATION_DIGESTS_H

#include <jansson.h>

#include "validation/compare.h"

/* Makes the digests of one record. `bone` contains the dims of the case's bone, which determine the numbers of the
   leaves of a tick. */
ost_status digests_of_record(const trace_record *r, ost_dims bone, json_t **out, ost_error *err);

/* Makes the digest lines of a case's records and sets *of_lines to their SHA-256. The caller frees *lines. */
ost_status digests_of_case(const trace *t, compare_range range, char **lines, ost_digest *of_lines, ost_error *err);

#endif
