/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Information about a session: its header, the records that it contains and those that are missing.
 */
#ifndef OST_APP_REPLAY_SESSION_INFO_H
#define OST_APP_REPLAY_SESSION_INFO_H

#include "app/common/app.h"

/* Runs osteon info on a session. repaired is the name of a new session to write with its intact
   records, or NULL. */
ost_status info_session(const app_state *app, const char *name, const char *repaired, ost_error *err);

/* Runs osteon export on a session: writes the table out, a .csv. */
ost_status export_session(const app_state *app, const char *name, const char *out, ost_error *err);

#endif
