/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a backend's trace, or its end, says about each case: the cells of a
 * campaign's results.
 *
 *   reference's trace, another's --verdict_judge--> equal, differs, failed
 *   a worker's end               --verdict_of_end-> failed, crashed, timed out
 */
#ifndef OST_VALIDATION_VERDICT_H
#define OST_VALIDATION_VERDICT_H

#include "validation/campaign.h"

/* The cell of a case and a backend. */
case_result *verdict_of(campaign *c, int case_index, int whom);

/* What one part of a backend's trace says about cases [from, until); how many of them it has whole. differs: one of them does. */
int verdict_judge(campaign *c, const trace *reference, int whom, const trace *got, int from, int until, bool *differs);

/* Of the case that a worker was at when it ended before its time. */
void verdict_of_end(const worker_result *end, case_result *out);

/* How near each differing voxel of case i was, owned by the caller; NULL where that cannot be said. */
margins *verdict_margins(const campaign *c, int i, const trace *got, compare_range range, bool apart);

#endif
