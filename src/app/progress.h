/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One line on the terminal's standard error for what takes more than a second,
 * with the time left; nothing when it is no terminal, nothing with --quiet.
 */
#ifndef OST_APP_PROGRESS_H
#define OST_APP_PROGRESS_H

#include "app/app.h"

double now_ms(void);

/* An ost_progress; user is not used. */
bool progress_show(void *user, const char *stage, double share);
void progress_begin(const app_state *app);
/* Takes the line away, before other text and at the end. */
void progress_clear(void);

#endif
