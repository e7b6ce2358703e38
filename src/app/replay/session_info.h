/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints or exports information about a session: its header, the records that it contains and those
 * that are missing.
 */
#ifndef OST_APP_REPLAY_SESSION_INFO_H
#define OST_APP_REPLAY_SESSION_INFO_H

#include "app/common/app.h"

/* Runs `osteon info` on a session. repaired: the name of a new session, to which the intact records
   are written; NULL if none is requested. */
ost_status info_session(const app_state *app, const char *name, const char *repaired, ost_error *err);

/* Runs `osteon export` on a session: writes a table to out, a .csv file. */
ost_status export_session(const app_state *app, const char *name, const char *out, ost_error *err);

#endif
