/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ctrl-C as a wish: between begin and end the first SIGINT, SIGTERM or SIGHUP
 * only sets a flag, so that what runs can end itself; the second ends the
 * process as usual.
 */
#ifndef OST_APP_INTERRUPT_H
#define OST_APP_INTERRUPT_H

#include <stdbool.h>

void interrupt_begin(void);
void interrupt_end(void);
/* A signal came since begin; a load, fit for a tick. Stays true after end. */
bool interrupt_asked(void);

/* The same wish from the program itself: its window was closed. */
void interrupt_ask(void);

#endif
