/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replays the session of `osteon replay`.
 *
 *   session --replay.h--> ticks --verify.h--> equal? --report.h--> text, JSON
 *                           '--> bone (--out), page (--debrief), video (film.h)
 */
#ifndef OST_APP_REPLAY_RUN_H
#define OST_APP_REPLAY_RUN_H

#include "app/replay/args.h"

/* Replays the session, writes the files and reports the result. Returns OST_ERR_DIFFER if a result differs. */
ost_status replay_session(app_state *app, const replay_args *args, ost_error *err);

#endif
