/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "core/huge_pages.h"

#include <stdint.h>
#include <sys/mman.h>

void ost_request_huge_pages(void *memory, size_t bytes)
{
#if defined MADV_HUGEPAGE
    const uintptr_t begin = ((uintptr_t)memory + OST_HUGE_PAGE - 1) / OST_HUGE_PAGE * OST_HUGE_PAGE;
    const uintptr_t end = ((uintptr_t)memory + bytes) / OST_HUGE_PAGE * OST_HUGE_PAGE;
    if (memory && begin < end)
        (void)madvise((void *)begin, end - begin, MADV_HUGEPAGE);
#else
    (void)memory;
    (void)bytes;
#endif
}
