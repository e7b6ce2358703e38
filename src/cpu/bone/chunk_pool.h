/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pool of blocks for chunks of one size. Freed blocks remain mapped for reuse.
 *
 *   extents     [ block | block | block | ...              ]  mapped; memory is touched on use
 *   stack       fresh ... fresh | returned ... returned <- top
 *               (lowest address last)
 *
 * Reserving blocks for a grid in which every chunk may be active uses addresses, not
 * memory: the system allocates pages when a block is first written, huge pages if
 * it supports them, and a trim releases the part of a huge page after the last
 * block.  Returned blocks are taken first, so that a second bone on the same
 * backend causes no page faults.
 *
 * Threads: any number of threads may take at the same time, or any number may give
 * at the same time.  Takes and gives must not overlap, and one thread at a time may
 * call the other functions.
 */
#ifndef OST_CPU_CHUNK_POOL_H
#define OST_CPU_CHUNK_POOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ost_chunk_pool ost_chunk_pool;

/* Creates a pool of blocks of block_bytes, a multiple of 64. Returns NULL if there is no memory. */
ost_chunk_pool *ost_chunk_pool_open(size_t block_bytes);
/* Frees the pool. Every block must have been returned. pool may be NULL. */
void ost_chunk_pool_close(ost_chunk_pool *pool);

/*
 * Ensures that the next `count` takes succeed. Returns false, without any change, if there are not
 * enough addresses or not enough memory.
 */
bool ost_chunk_pool_reserve(ost_chunk_pool *pool, int64_t count);
/*
 * Returns the number of bytes that the pool uses in addition to the blocks: its stack, and up to a page after the last
 * block.
 */
size_t ost_chunk_pool_overhead(const ost_chunk_pool *pool);
/* Returns a 64-byte aligned block of undefined content, or NULL if no reserved block is available. */
void *ost_chunk_pool_take(ost_chunk_pool *pool);
/* Returns a block to the pool. */
void ost_chunk_pool_give(ost_chunk_pool *pool, void *block);
/*
 * Releases pages that no block uses: those after the last block touched, or all pages if no block
 * is in use and many are mapped.
 */
void ost_chunk_pool_trim(ost_chunk_pool *pool);

#endif
