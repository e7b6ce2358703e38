/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calls a kernel so that whatever it does comes back as a sentence: a fault
 * (and where), a call that does not end, state that it owed its caller.
 */
#ifndef OST_TESTS_SIMD_CALL_H
#define OST_TESTS_SIMD_CALL_H

#include <stdbool.h>
#include <stddef.h>

/* Any kernel; cast back to its type before it is called. */
typedef void check_fn(void);
/* Calls kernel with the arguments, a structure of its own. */
typedef void check_call_fn(check_fn *kernel, void *arguments);

typedef enum call_end { CALL_RETURNED, CALL_FAULT, CALL_STATE } call_end;

/* Once, before the first call. A call that takes longer than this many seconds of processor time (or up to twice as long) is ended. */
void call_watch(double seconds);
/* What went wrong goes to text. */
call_end call_kernel(check_call_fn *call, check_fn *kernel, void *arguments, char *text, size_t size);
/* Whether upper halves of vector registers that are left in use are noticed here. */
bool call_watches_halves(void);
/* Whether there is no sense in any of this: says why. */
bool call_under_valgrind(void);

#endif
