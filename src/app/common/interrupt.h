/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ctrl-C as a request: between interrupt_begin and interrupt_end the first SIGINT, SIGTERM or
 * SIGHUP only sets a flag, so that the running work can end in order; the second ends the process
 * as usual.
 */
#ifndef OST_APP_COMMON_INTERRUPT_H
#define OST_APP_COMMON_INTERRUPT_H

#include <stdbool.h>

void interrupt_begin(void);
void interrupt_end(void);
/* Returns true if a signal came since interrupt_begin. One atomic load, cheap enough for every
   tick. Stays true after interrupt_end. */
bool interrupt_requested(void);

/* Sets the flag from within the program, when its window was closed. */
void interrupt_request(void);

#endif
