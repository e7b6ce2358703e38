/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A progress line on standard error for work of more than a second, with the remaining time. There
 * is none if standard error is not a terminal, and none with --quiet.
 */
#ifndef OST_APP_COMMON_PROGRESS_H
#define OST_APP_COMMON_PROGRESS_H

#include "app/common/app.h"

double now_ms(void);

/* An ost_progress; user is not used. */
bool progress_show(void *user, const char *stage, double share);
void progress_begin(const app_state *app);
/* Erases the line, before other text and at the end. */
void progress_clear(void);

#endif
