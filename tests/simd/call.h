/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calls a kernel and reports errors as text. The errors are a fault, which is reported with its address, a call that
 * does not end, and processor state that the kernel does not restore.
 */
#ifndef OST_TESTS_SIMD_CALL_H
#define OST_TESTS_SIMD_CALL_H

#include <stdbool.h>
#include <stddef.h>

/* Any kernel. The pointer is cast back to the kernel's type before the call. */
typedef void check_fn(void);
/* Calls the kernel with its arguments. The type of the arguments is a struct specific to the kernel. */
typedef void check_call_fn(check_fn *kernel, void *arguments);

typedef enum call_end { CALL_RETURNED, CALL_FAULT, CALL_STATE } call_end;

/*
 * Sets the time limit of a call in seconds of CPU time. A call that exceeds the limit is ended after at
 * most twice this time. This function must be called once before the first call of call_kernel.
 */
void call_watch(double seconds);
/* Calls `kernel` through `call`. If the result is not CALL_RETURNED, `text` describes the error. */
call_end call_kernel(check_call_fn *call, check_fn *kernel, void *arguments, char *text, size_t size);
/* Returns true if this machine and this build can detect a kernel that leaves the upper halves of vector registers
   in use. */
bool call_watches_halves(void);
/* If the program runs under valgrind, prints why the checks are skipped there, and returns true. */
bool call_under_valgrind(void);

#endif
