/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints a progress line with the remaining time on standard error, for work of more than a second.
 * Prints nothing if standard error is not a terminal or --quiet is given.
 */
#ifndef OST_APP_COMMON_PROGRESS_H
#define OST_APP_COMMON_PROGRESS_H

#include "app/common/app.h"

double now_ms(void);

/* Implements ost_progress; user is not used. */
bool progress_show(void *user, const char *stage, double share);
void progress_begin(const app_state *app);
/* Erases the progress line. Called before other text is printed, and at the end. */
void progress_clear(void);

#endif
