/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints a progress line on standard error if work takes more than a second. The line contains the stage, the completed
 * share and the remaining time. If the share is not known, the line contains the elapsed time instead.
 *
 *   verb, callbacks of the library --progress_show--> stage, share --thread, ten times a second--> line
 *
 * A separate thread draws the line, so that the line also appears during a stage that reports no share. If standard
 * error is not a terminal or --quiet is given, nothing is printed and no thread exists.
 */
#ifndef OST_APP_COMMON_PROGRESS_H
#define OST_APP_COMMON_PROGRESS_H

#include "app/common/app.h"

double now_ms(void);

/* Starts the clock of a verb. Called once, after the options have been parsed. */
void progress_begin(const app_state *app);
/*
 * Sets the stage and the completed share, from 0 to 1. A share of 0 also means that the share is not known. Implements
 * ost_progress. `user` is not used. May be called on any thread. Returns true.
 */
bool progress_show(void *user, const char *stage, double share);
/* Erases the line. Called before other text is printed. If the stage continues, the line is drawn again later. */
void progress_clear(void);
/* Ends the stage and erases the progress line. */
void progress_end(void);

#endif
