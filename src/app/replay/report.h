/* SPDX-License-Identifier: Apache-2.0 */
/* Reports the result of a replay: the counts, the digest of the bone, and the first difference. */
#ifndef OST_APP_REPLAY_REPORT_H
#define OST_APP_REPLAY_REPORT_H

#include "app/replay/args.h"
#include "app/replay/verify.h"

/*
 * Returns true if --verify found no difference, but the file is incomplete and contains fewer ticks than were
 * requested.
 */
bool replay_verified_in_part(const replay_args *args, const replay *r, const replay_ending *e);

/*
 * Prints the result and stores it in app->result. With --verify, locates the first difference. Returns OST_ERR_DIFFER
 * if the replay differs from the recording, and OST_ERR_INPUT if the recording was verified only in part.
 */
ost_status replay_report(app_state *app, const replay_args *args, replay *r, const replay_ending *e, ost_error *err);

#endif
