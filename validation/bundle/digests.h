/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Digests of a trace's records, for cases.jsonl.
 *
 *   {stage, item, sha256 of the body, leaves}
 *
 * leaves are AR-DIG-2's, of 32^3 voxels: all in order for a whole grid, and
 * [number, digest] for the leaves that a tick changed.  Two sites that
 * exchange these alone find the stage, the tick and the chunk that differ.
 */
#ifndef OST_VALIDATION_DIGESTS_H
#define OST_VALIDATION_DIGESTS_H

#include <jansson.h>

#include "validation/trace.h"

/* bone: dims of the case's bone, for numbering a tick's leaves. */
ost_status digests_of_record(const trace_record *r, ost_dims bone, json_t **out, ost_error *err);

#endif
