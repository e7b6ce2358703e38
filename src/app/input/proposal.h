/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Landmarks that are proposed for a bone (--landmarks auto) instead of read from a file.
 *
 *   bone --ost_scapula_landmarks_find--> landmarks --> header, as if they were read from a file
 *                                            '------> report with figures that state how sure they are
 */
#ifndef OST_APP_INPUT_PROPOSAL_H
#define OST_APP_INPUT_PROPOSAL_H

#include "app/common/app.h"

#include <osteon/backend.h>
#include <osteon/io.h>
#include <osteon/metrics.h>

#define PROPOSAL_AUTO "auto"           /* value of --landmarks */
#define PROPOSAL_FACT "landmarks_proposed" /* fact of the header: the spreads of the landmarks */

/*
 * Proposes the landmarks of a bone, stores side and spreads in meta, and reports them. The caller frees *out by
 * ost_landmarks_free.
 */
ost_status proposal_make(const app_state *app, const ost_bone *bone, const char *name, ost_meta *meta,
                         ost_landmarks *out, ost_error *err);

/* Prints version and inclination, and adds them to the result, if the facts of a bone's header determine them. */
ost_status angles_report(const app_state *app, const ost_meta *meta, ost_error *err);

#endif
