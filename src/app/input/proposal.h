/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Proposes landmarks for a bone (--landmarks auto) instead of reading them from a file.
 *
 *   bone --ost_scapula_landmarks_find--> landmarks --> header, as if they were read from a file
 *                                            '------> report, with the spreads of the landmarks
 */
#ifndef OST_APP_INPUT_PROPOSAL_H
#define OST_APP_INPUT_PROPOSAL_H

#include "app/common/app.h"

#include <osteon/backend.h>
#include <osteon/io.h>
#include <osteon/metrics.h>

#define PROPOSAL_AUTO "auto"           /* value of --landmarks */
#define PROPOSAL_FACT "landmarks_proposed" /* key of the header fact that contains the spreads of proposed landmarks */

/*
 * Proposes the landmarks of a bone, stores the side and the spreads in meta, and reports the landmarks. The caller
 * frees *out with ost_landmarks_free.
 */
ost_status proposal_make(const app_state *app, const ost_bone *bone, const char *name, ost_meta *meta,
                         ost_landmarks *out, ost_error *err);

/* If the header facts of a bone determine version and inclination, prints these angles and adds them to the result. */
ost_status angles_report(const app_state *app, const ost_meta *meta, ost_error *err);

#endif
