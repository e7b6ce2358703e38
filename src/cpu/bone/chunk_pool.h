/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory for chunks of one size, kept warm.
 *
 *   extents     [ block | block | block | ...              ]  mapped, touched as it is used
 *   stack       fresh ... fresh | given back ... given back <- taken from here
 *               (lowest address last)
 *
 * A grid of which every chunk may be active reserves addresses, not memory:
 * pages come when a block is first written, in huge pages where the system
 * gives them, and a trim gives back what a huge page has behind the last
 * block.  Blocks that were given back are taken first, so a second bone on the
 * same backend meets no page fault.
 *
 * Threads: any number may take at once, or any number may give at once; takes
 * and gives never overlap, and everything else is for one thread alone.
 */
#ifndef OST_CPU_CHUNK_POOL_H
#define OST_CPU_CHUNK_POOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ost_chunk_pool ost_chunk_pool;

/* block_bytes is a multiple of 64. NULL when there is no memory. */
ost_chunk_pool *ost_chunk_pool_open(size_t block_bytes);
/* Every block must have been given back. NULL is allowed. */
void ost_chunk_pool_close(ost_chunk_pool *pool);

/* After it, `count` takes succeed. False when there are no addresses left; nothing has changed then. */
bool ost_chunk_pool_reserve(ost_chunk_pool *pool, int64_t count);
/* Bytes that it holds beside the blocks: the stack, and what the last page has behind the last block. */
size_t ost_chunk_pool_overhead(const ost_chunk_pool *pool);
/* A block of 64-byte aligned, undefined content, or NULL when none is reserved. */
void *ost_chunk_pool_take(ost_chunk_pool *pool);
void ost_chunk_pool_give(ost_chunk_pool *pool, void *block);
/* Gives pages back that no block uses: behind the last one touched, and all of them when much is kept for nobody. */
void ost_chunk_pool_trim(ost_chunk_pool *pool);

#endif
