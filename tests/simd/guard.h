/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory that notices what a kernel must not do with it.
 *
 *    no access |  poison, canary  |  the buffer  | no access        placed at the end
 *    no access | the buffer |  canary, poison     | no access        at the beginning
 *
 * A buffer lies right at one edge of its pages (up to its alignment): one
 * element read or written beyond is a fault there, and one written beyond the
 * other edge breaks the canary.  Which edge is up to the caller, by turns.
 * Inputs are made read-only while a kernel runs, so that writing to one is a
 * fault as well.  Outputs begin as poison.
 */
#ifndef OST_TESTS_SIMD_GUARD_H
#define OST_TESTS_SIMD_GUARD_H

#include <stdbool.h>
#include <stddef.h>

typedef enum guard_kind { GUARD_INPUT, GUARD_OUTPUT } guard_kind;

/* size bytes of poison, valid until guard_reset. size and align (a power of two up to 4096) are in bytes; name is kept. */
void *guard_take(const char *name, size_t size, size_t align, guard_kind kind, bool at_end);
/* Makes the inputs read-only. */
void guard_freeze(void);
/* Whether no canary is broken; else says in text which, and how far from its buffer. */
bool guard_intact(char *text, size_t size);
/* Says in text which buffer an address lies in or beside. */
void guard_describe(const void *address, char *text, size_t size);
/* Gives every buffer back; the pages are kept. */
void guard_reset(void);

#endif
