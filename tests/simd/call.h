/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calls a kernel and describes its errors in a sentence: a fault and its place, a call that does
 * not end, or processor state that was not restored.
 */
#ifndef OST_TESTS_SIMD_CALL_H
#define OST_TESTS_SIMD_CALL_H

#include <stdbool.h>
#include <stddef.h>

/* Any kernel; it is cast back to its type before it is called. */
typedef void check_fn(void);
/* Calls kernel with its arguments, a struct specific to the kernel. */
typedef void check_call_fn(check_fn *kernel, void *arguments);

typedef enum call_end { CALL_RETURNED, CALL_FAULT, CALL_STATE } call_end;

/*
 * Sets the time limit of a call in seconds of CPU time. A call that takes longer is ended after at
 * most twice this time. Must be called once before the first call_kernel.
 */
void call_watch(double seconds);
/* Calls `kernel` through `call`. If the result is not CALL_RETURNED, `text` describes the error. */
call_end call_kernel(check_call_fn *call, check_fn *kernel, void *arguments, char *text, size_t size);
/* Returns true if this machine and build can detect that upper halves of vector registers are left in use. */
bool call_watches_halves(void);
/* Returns true and prints the reason if the program runs under valgrind, where these checks do not work. */
bool call_under_valgrind(void);

#endif
