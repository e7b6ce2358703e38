/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks a bundle's protocol and cases against the plan of its tier, seed, shard and options. For this
 * check, the plan is generated again.
 *
 *   protocol.json --tier, seed, shard, only, case--> plan --> the protocol again: every key must be equal
 *                                                      '--> the cases of cases.jsonl, in this order, with the inputs
 *                                                           of the plan (except those of the user's own files)
 *   devices.json, tools.json, environment.json, times.json, sensitivity.json: must come from the run of this protocol
 *
 * The check detects, for example, a smoke campaign labelled as standard, a missing case or backend, and a
 * file from another run or another build.
 */
#ifndef OST_VALIDATION_PLANNED_H
#define OST_VALIDATION_PLANNED_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* Makes the plan of a protocol. If the protocol has the member "case", the plan contains the cases in this member;
   otherwise, it follows from the tier, seed, shard and options. The caller frees the plan with plan_free. Returns
   OST_ERR_INPUT with an error line if the protocol is invalid. */
ost_status planned_of(const json_t *protocol, const plan_user *user, plan *out, ost_error *err);

/* Reports differences between the bundle and the plan. The protocol must be an object of the format EVIDENCE_FORMAT;
   cases must be an array. */
ost_status planned_check(const json_t *protocol, const json_t *cases, bundle_problem *problem, void *user, int *found,
                         ost_error *err);

/* Reports missing measured files, and contradictions between measured files or between a measured file and the
   protocol. */
ost_status linked_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                        ost_error *err);

#endif
