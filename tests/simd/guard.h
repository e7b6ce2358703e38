/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory that detects wrong accesses by a kernel.
 *
 *    no access |  poison, canary  |  the buffer  | no access        placed at the end
 *    no access | the buffer |  canary, poison     | no access        at the beginning
 *
 * A buffer lies directly at one edge of its pages, or as near to the edge as its alignment allows. Reading
 * or writing one element beyond that edge causes a fault, and writing beyond the other edge changes the
 * canary. The caller chooses the edge. Inputs are read-only while a kernel runs, so that writing to them
 * also causes a fault. Outputs initially contain poison.
 */
#ifndef OST_TESTS_SIMD_GUARD_H
#define OST_TESTS_SIMD_GUARD_H

#include <stdbool.h>
#include <stddef.h>

typedef enum guard_kind { GUARD_INPUT, GUARD_OUTPUT } guard_kind;

/*
 * Returns a buffer of `size` bytes, filled with poison. `align` is a power of two of at most 4096
 * bytes. guard_reset releases the buffer; the text `name` must be valid until then.
 */
void *guard_take(const char *name, size_t size, size_t align, guard_kind kind, bool at_end);
/* Makes the inputs read-only. */
void guard_freeze(void);
/* Returns true if all canaries are intact. If a canary has changed, writes to `text` the name of its buffer and the
   distance of the changed byte from this buffer. */
bool guard_intact(char *text, size_t size);
/* Writes to `text` the name of the buffer that contains the address or is adjacent to it. */
void guard_describe(const void *address, char *text, size_t size);
/* Releases every buffer. The pages are reused for later buffers. */
void guard_reset(void);

#endif
