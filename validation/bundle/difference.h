/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares two bundles from different sites by the digests of the reference's results. There is a digest
 * for each record and for each leaf of 32^3 voxels. The digests are sufficient to find the stage, the tick
 * and the chunk that differ. The sites need not exchange voxels.
 *
 *   A/protocol.json, cases.jsonl --.
 *                                   '--case by case, record by record--> first stage, tool or tick, leaf
 *   B/protocol.json, cases.jsonl --'
 *
 * A case is compared if both bundles have a case with the same name and the same input. The cases that are not
 * compared are listed. If any case is not compared, the bundles are not reported as equal. Bundles may come from
 * untrusted sources, so all their content is checked. This code does not check that a bundle is unchanged; `osteon
 * verify` checks this.
 */
#ifndef OST_VALIDATION_DIFFERENCE_H
#define OST_VALIDATION_DIFFERENCE_H

#include <jansson.h>
#include <osteon/status.h>

/* value of `what` if only one of the two bundles contains the record */
#define DIFFERENCE_NO_RECORD "one of them has no such record"

/*
 * Compares bundles a and b, which are called name_a and name_b in the result. The caller owns the result:
 * {kind: "bundles", equal, compared, different_cases, differences[] {case, stage, item, what, leaf, chunk},
 *  not_compared[], notes[]}. Returns OST_ERR_INPUT if one of the folders is not a bundle.
 */
ost_status bundle_difference(const char *a, const char *b, const char *name_a, const char *name_b, json_t **out,
                             ost_error *err);

#endif
