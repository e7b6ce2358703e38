/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bundle's protocol and cases against the plan that follows from its tier,
 * seed, shard and options, made again by this program.
 *
 *   protocol.json --tier, seed, shard, only, case--> plan --> the protocol again: every key must be equal
 *                                                      '--> the cases of cases.jsonl, in this order, with the inputs
 *                                                           that the plan gives (of the user's own files: not here)
 *   devices.json, tools.json, environment.json, times.json, sensitivity.json: of the same run, as far as they say
 *
 * So a smoke relabelled standard is found, a case or a backend left out, and a
 * file of another run or another build.
 */
#ifndef OST_VALIDATION_PLANNED_H
#define OST_VALIDATION_PLANNED_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* The plan of a protocol: from its case, or from tier, seed, shard and options. plan_free() it. OST_ERR_INPUT in one line. */
ost_status planned_of(const json_t *protocol, const plan_user *user, plan *out, ost_error *err);

/* Reports what differs from the plan; the protocol is an object of this format, cases an array. */
ost_status planned_check(const json_t *protocol, const json_t *cases, bundle_problem *problem, void *user, int *found,
                         ost_error *err);

/* Reports what the files that were measured contradict each other or the protocol in, and which are missing. */
ost_status linked_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                        ost_error *err);

#endif
