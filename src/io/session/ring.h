/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ring buffer of records between one producer thread and one consumer thread.
 *
 *         tail                head
 *   ...|  waiting, tail..head  |  free  ...      record number n is in slot n % capacity
 *
 * The numbers head and tail only increase. The producer writes a slot and then head (release). The consumer reads head
 * (acquire) and the slots, and then writes tail (release). The producer reads tail (acquire) before it reuses a slot.
 * Neither thread waits for the other. The producer caches the tail and rereads it only if the ring seems full, which
 * happens about once in `capacity` puts. All other puts touch no cache line that the consumer writes.
 */
#ifndef OST_IO_SESSION_RING_H
#define OST_IO_SESSION_RING_H

#include <stdatomic.h>
#include <stdlib.h>

#include "io/session/layout.h"

enum { RING_LINE = 64 };

typedef struct session_ring {
    unsigned char *slots; /* owned; space for `capacity` records */
    uint64_t capacity;    /* number of slots; a power of two */
    _Alignas(RING_LINE) _Atomic uint64_t head;
    uint64_t tail_known; /* producer's cached copy of tail */
    _Alignas(RING_LINE) _Atomic uint64_t tail;
} session_ring;

/* Allocates the ring and touches each of its pages, so that no page fault occurs during a tick. */
static inline bool ring_open(session_ring *ring, uint64_t capacity)
{
    ring->slots = malloc(capacity * SESSION_RECORD);
    if (!ring->slots)
        return false;
    memset(ring->slots, 0xff, capacity * SESSION_RECORD);
    ring->capacity = capacity;
    return true;
}

static inline void ring_close(session_ring *ring)
{
    free(ring->slots);
}

/*
 * Called by the producer. Returns the next free slot, or NULL if the ring is full. The caller fills the slot and
 * publishes it with ring_push.
 */
static inline unsigned char *ring_slot(session_ring *ring)
{
    const uint64_t head = atomic_load_explicit(&ring->head, memory_order_relaxed);
    if (head - ring->tail_known == ring->capacity) {
        ring->tail_known = atomic_load_explicit(&ring->tail, memory_order_acquire);
        if (head - ring->tail_known == ring->capacity)
            return NULL;
    }
    return ring->slots + (head & (ring->capacity - 1)) * SESSION_RECORD;
}

static inline void ring_push(session_ring *ring)
{
    atomic_store_explicit(&ring->head, atomic_load_explicit(&ring->head, memory_order_relaxed) + 1,
                          memory_order_release);
}

/*
 * Called by the consumer. ring_waiting returns the number of waiting records, ring_copy copies the first `count` of
 * them, and ring_pop frees the slots of the first `count`.
 */
static inline uint64_t ring_waiting(session_ring *ring)
{
    return atomic_load_explicit(&ring->head, memory_order_acquire) -
           atomic_load_explicit(&ring->tail, memory_order_relaxed);
}

static inline void ring_copy(const session_ring *ring, unsigned char *out, uint64_t count)
{
    const uint64_t at = atomic_load_explicit(&ring->tail, memory_order_relaxed) & (ring->capacity - 1);
    const uint64_t first = count < ring->capacity - at ? count : ring->capacity - at;
    memcpy(out, ring->slots + at * SESSION_RECORD, first * SESSION_RECORD);
    memcpy(out + first * SESSION_RECORD, ring->slots, (count - first) * SESSION_RECORD);
}

static inline void ring_pop(session_ring *ring, uint64_t count)
{
    atomic_store_explicit(&ring->tail, atomic_load_explicit(&ring->tail, memory_order_relaxed) + count,
                          memory_order_release);
}

#endif
