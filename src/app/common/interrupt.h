/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Handles Ctrl-C. Between interrupt_begin and interrupt_end, the first SIGINT, SIGTERM or SIGHUP only sets a flag, so
 * that the current work can end in an orderly way. The second signal terminates the process as usual.
 */
#ifndef OST_APP_COMMON_INTERRUPT_H
#define OST_APP_COMMON_INTERRUPT_H

#include <stdbool.h>

void interrupt_begin(void);
void interrupt_end(void);
/*
 * Returns true if a signal arrived after interrupt_begin; the result remains true after interrupt_end. The call is
 * one atomic load, so it may be made in every tick.
 */
bool interrupt_requested(void);

/* Sets the flag from within the program, for example when the user closes the program's window. */
void interrupt_request(void);

#endif
