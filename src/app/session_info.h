/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sessions as the command shows them: what one says of itself, what of it is
 * there and what is not.
 */
#ifndef OST_APP_SESSION_INFO_H
#define OST_APP_SESSION_INFO_H

#include "app/app.h"

/* osteon info SESSION: repaired is the name of a new session to make of it, or NULL. */
ost_status info_session(const app_state *app, const char *name, const char *repaired, ost_error *err);

/* osteon export SESSION --out FILE.csv, .mcap or .h5; voxels: also which went, by doing it again */
ost_status export_session(const app_state *app, const char *name, const char *out, bool voxels, ost_error *err);

/* Into result and for people: the numbers of a summary, and one warning for what is missing. */
void put_session_summary(const app_state *app, const char *name, const ost_session *session);

#endif
