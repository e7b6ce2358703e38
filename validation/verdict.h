/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Derives the verdict of each pair of case and backend from the backend's trace
 * or from the way in which its worker ended.
 *
 *   reference's trace, another's --verdict_judge--> equal, differs, failed
 *   a worker's end               --verdict_of_end-> failed, crashed, timed out
 */
#ifndef OST_VALIDATION_VERDICT_H
#define OST_VALIDATION_VERDICT_H

#include "validation/campaign.h"

/* Returns the result of a case on the backend `subject_index`; owned by the campaign. */
case_result *verdict_of(campaign *c, int case_index, int subject_index);

/* Judges cases [from, until) from a part of a backend's trace. Returns the number of these cases that are complete in
   the trace. Sets *differs to true if at least one of them differs. */
int verdict_judge(campaign *c, const trace *reference, int subject_index, const trace *got, int from, int until,
                  bool *differs);

/* Stores the verdict of the case that a worker was running when it ended prematurely. */
void verdict_of_end(const worker_result *end, case_result *out);

/* Returns the margins of the differing voxels of case i, owned by the caller; NULL if they cannot be computed. */
margins *verdict_margins(const campaign *c, int i, const trace *got, compare_range range, bool apart);

#endif
