/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pool of blocks for chunks of one size. Freed blocks remain mapped for reuse.
 *
 *   extents     [ block | block | block | ...              ]  mapped; memory is allocated on use
 *   stack       fresh ... fresh | returned ... returned <- top
 *               (lowest address last)
 *
 * Blocks are reserved for all chunks of a grid, because every chunk may become active.  Reserved
 * blocks use address space but no memory: the system allocates pages when a block is first written,
 * and uses huge pages if it supports them.  ost_chunk_pool_trim releases the part of a huge page
 * after the last used block.  Returned blocks are taken before fresh blocks (those that were never
 * taken), so that a second bone on the same backend causes no page faults.
 *
 * Threads: several threads may call ost_chunk_pool_take at the same time, and several threads may call
 * ost_chunk_pool_give at the same time.  Calls of ost_chunk_pool_take must not overlap calls of ost_chunk_pool_give.
 * Only one thread at a time may call the other functions.
 */
#ifndef OST_CPU_CHUNK_POOL_H
#define OST_CPU_CHUNK_POOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ost_chunk_pool ost_chunk_pool;

/* Creates a pool of blocks of block_bytes bytes each. block_bytes must be a multiple of 64. Returns NULL if memory is
   exhausted. */
ost_chunk_pool *ost_chunk_pool_open(size_t block_bytes);
/* Frees the pool. Every block must have been returned to the pool before. The argument may be NULL. */
void ost_chunk_pool_close(ost_chunk_pool *pool);

/*
 * Ensures that the next `count` calls of ost_chunk_pool_take succeed. Returns false, without changing the pool, if
 * address space or memory is insufficient.
 */
bool ost_chunk_pool_reserve(ost_chunk_pool *pool, int64_t count);
/*
 * Returns the number of bytes that the pool uses in addition to its blocks: the stack, and up to one page after the
 * last used block.
 */
size_t ost_chunk_pool_overhead(const ost_chunk_pool *pool);
/*
 * Removes a reserved block from the pool and returns it. The block is 64-byte aligned and its content is undefined.
 * Returns NULL if no reserved block is available.
 */
void *ost_chunk_pool_take(ost_chunk_pool *pool);
/* Puts a block from ost_chunk_pool_take back into the pool. */
void ost_chunk_pool_give(ost_chunk_pool *pool, void *block);
/*
 * Releases pages that no block uses: the pages after the last used block, or all pages if no block is in
 * use and many pages are mapped.
 */
void ost_chunk_pool_trim(ost_chunk_pool *pool);

#endif
