/* SPDX-License-Identifier: Apache-2.0 */
/* A hint to the system for large allocations. */
#ifndef OST_CORE_HUGE_PAGES_H
#define OST_CORE_HUGE_PAGES_H

#include <stddef.h>

/* Size of a huge page in bytes. A large block is aligned to this size, so that it can begin with a huge page. */
#define OST_HUGE_PAGE ((size_t)1 << 21)

/*
 * Requests huge pages for the memory of a large block, before it is first written. A page fault then provides 2 MB
 * instead of 4 kB. Only pages that lie entirely in the block are affected. The request affects only the speed, so
 * errors are ignored. May be called on any thread. `memory` may be NULL.
 */
void ost_request_huge_pages(void *memory, size_t bytes);

#endif
