/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pool of memory blocks (chunk_pool.h). The stack contains the blocks that are not in use, and their number is an
 * atomic variable. ost_chunk_pool_take decrements this number, and ost_chunk_pool_give increments it. Each call thus
 * gets the index of a stack element that no other thread accesses. Because no call of ost_chunk_pool_take overlaps a
 * call of ost_chunk_pool_give, threads need no other synchronisation.
 */
#include "cpu/bone/chunk_pool.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "core/huge_pages.h"

enum { EXTENTS_MAX = 64 };
/* If no block is in use, ost_chunk_pool_trim leaves at most RETAINED_BYTES bytes of previously used blocks mapped. */
#define RETAINED_BYTES ((size_t)1 << 28)

typedef struct extent {
    unsigned char *base; /* start of the extent, aligned to the size of a huge page */
    size_t bytes;
} extent;

struct ost_chunk_pool {
    size_t block_bytes;
    extent extents[EXTENTS_MAX];
    int extent_count;
    int64_t total;
    /* number of blocks that have never been taken, which are stack[0] to stack[fresh - 1] */
    atomic_llong fresh;
    int64_t trimmed;    /* value of `fresh` at the last call of ost_chunk_pool_trim */
    void **stack;       /* owned array with `total` elements */
    atomic_llong available;
};

ost_chunk_pool *ost_chunk_pool_open(size_t block_bytes)
{
    assert(block_bytes > 0 && block_bytes % 64 == 0);
    ost_chunk_pool *pool = calloc(1, sizeof *pool);
    if (pool)
        pool->block_bytes = block_bytes;
    return pool;
}

static void unmap_all(ost_chunk_pool *pool)
{
    for (int i = 0; i < pool->extent_count; i++)
        munmap(pool->extents[i].base, pool->extents[i].bytes);
    free(pool->stack);
    pool->stack = NULL;
    pool->extent_count = 0;
    pool->total = pool->trimmed = 0;
    atomic_store(&pool->fresh, 0);
    atomic_store(&pool->available, 0);
}

void ost_chunk_pool_close(ost_chunk_pool *pool)
{
    if (!pool)
        return;
    assert(atomic_load(&pool->available) == pool->total);
    unmap_all(pool);
    free(pool);
}

/*
 * Reserves an address range that is aligned to the size of a huge page, without allocating memory. The function maps
 * one huge page more than needed and unmaps the excess at both ends.
 */
static unsigned char *map_aligned(size_t bytes)
{
    size_t mapped_bytes = bytes + OST_HUGE_PAGE;
    void *map = mmap(NULL, mapped_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (map == MAP_FAILED)
        return NULL;
    unsigned char *begin = map;
    size_t before = (OST_HUGE_PAGE - (uintptr_t)begin % OST_HUGE_PAGE) % OST_HUGE_PAGE;
    if (before > 0)
        munmap(begin, before);
    munmap(begin + before + bytes, OST_HUGE_PAGE - before);
    ost_request_huge_pages(begin + before, bytes);
    return begin + before;
}

bool ost_chunk_pool_reserve(ost_chunk_pool *pool, int64_t count)
{
    int64_t available = atomic_load(&pool->available);
    if (available >= count)
        return true;
    if (pool->extent_count == EXTENTS_MAX)
        return false;
    /* The size of the pool is at least doubled, so that few extents are needed. count <= 2^24, block_bytes < 2^20. */
    int64_t more = count - available > pool->total ? count - available : pool->total;
    size_t bytes = ((size_t)more * pool->block_bytes + OST_HUGE_PAGE - 1) / OST_HUGE_PAGE * OST_HUGE_PAGE;
    void **stack = realloc(pool->stack, (size_t)(pool->total + more) * sizeof *stack);
    if (!stack)
        return false;
    pool->stack = stack;
    unsigned char *base = map_aligned(bytes);
    if (!base)
        return false;
    memmove(stack + more, stack, (size_t)available * sizeof *stack);
    for (int64_t i = 0; i < more; i++)
        stack[i] = base + (size_t)(more - 1 - i) * pool->block_bytes;
    pool->extents[pool->extent_count++] = (extent){base, bytes};
    pool->total += more;
    pool->trimmed += more;
    atomic_fetch_add(&pool->fresh, more);
    atomic_store(&pool->available, available + more);
    return true;
}

size_t ost_chunk_pool_overhead(const ost_chunk_pool *pool)
{
    return sizeof *pool + (size_t)pool->total * sizeof *pool->stack + (size_t)sysconf(_SC_PAGESIZE);
}

void *ost_chunk_pool_take(ost_chunk_pool *pool)
{
    long long left = atomic_fetch_sub_explicit(&pool->available, 1, memory_order_relaxed);
    if (left > 0) {
        long long fresh = atomic_load_explicit(&pool->fresh, memory_order_relaxed);
        while (left - 1 < fresh && !atomic_compare_exchange_weak(&pool->fresh, &fresh, left - 1))
            continue;
        return pool->stack[left - 1];
    }
    atomic_fetch_add_explicit(&pool->available, 1, memory_order_relaxed);
    return NULL;
}

void ost_chunk_pool_give(ost_chunk_pool *pool, void *block)
{
    long long at = atomic_fetch_add_explicit(&pool->available, 1, memory_order_relaxed);
    assert(at < pool->total);
    pool->stack[at] = block;
}

void ost_chunk_pool_trim(ost_chunk_pool *pool)
{
    int64_t fresh = atomic_load(&pool->fresh);
    if (atomic_load(&pool->available) == pool->total &&
        (size_t)(pool->total - fresh) * pool->block_bytes > RETAINED_BYTES) {
        unmap_all(pool);
        return;
    }
    if (fresh == pool->trimmed)
        return;
    pool->trimmed = fresh;
    if (fresh == 0)
        return;
    /*
     * The last used block ends where the block stack[fresh - 1] begins. The system may have allocated a huge page that
     * contains this position. The part of this huge page after the position is released.
     */
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uintptr_t begin = ((uintptr_t)pool->stack[fresh - 1] + page - 1) / page * page;
    uintptr_t end = (begin + OST_HUGE_PAGE - 1) / OST_HUGE_PAGE * OST_HUGE_PAGE;
    if (begin < end)
        (void)madvise((void *)begin, end - begin, MADV_DONTNEED);
}
