/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Two bundles of two sites, compared by what they hold of the reference's
 * results: digests, of records and of leaves of 32^3 voxels.  No voxel is
 * exchanged, and still the stage, tick and chunk are found.
 *
 *   A/protocol.json, cases.jsonl --.
 *                                   '--case by case, record by record--> first stage, tool or tick, leaf
 *   B/protocol.json, cases.jsonl --'
 *
 * Cases are compared where both have one of that name with the same input;
 * what cannot be compared is listed, and then the bundles are not called
 * equal.  Bundles come from others: nothing in them is trusted; whether they
 * are what they were when written is for osteon verify.
 */
#ifndef OST_VALIDATION_DIFFERENCE_H
#define OST_VALIDATION_DIFFERENCE_H

#include <jansson.h>
#include <osteon/status.h>

/* The name of a difference where one bundle alone has a record. */
#define DIFFERENCE_NO_RECORD "one of them has no such record"

/*
 * name_a, name_b: what the result calls the bundles.
 * {kind: "bundles", equal, compared, different_cases, differences[] {case, stage, item, what, leaf, chunk},
 *  not_compared[], notes[]}; the caller's reference.  OST_ERR_INPUT where one is no bundle.
 */
ost_status bundle_difference(const char *a, const char *b, const char *name_a, const char *name_b, json_t **out, ost_error *err);

#endif
