/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints or exports information about a session: its header, its records, and the records that are missing.
 */
#ifndef OST_APP_REPLAY_SESSION_INFO_H
#define OST_APP_REPLAY_SESSION_INFO_H

#include "app/common/app.h"

/*
 * Runs `osteon info` on a session. If `repaired` is not NULL, also writes the intact records to a new session with
 * this name.
 */
ost_status info_session(const app_state *app, const char *name, const char *repaired, ost_error *err);

/* Implements `osteon export` for a session: writes its ticks as a CSV table to `out`. */
ost_status export_session(const app_state *app, const char *name, const char *out, ost_error *err);

#endif
