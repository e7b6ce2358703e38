/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Passes the newest value from one thread to another, wait-free on both sides. There are three slots: one belongs to
 * the writer, one belongs to the reader, and writer and reader exchange the third.
 *
 *   writer: back --exchange--> middle --exchange--> front :reader
 *
 * If the writer publishes a value before the reader has taken the previous one, the previous value
 * is dropped.
 */
#ifndef OST_HAPTICS_NEWEST_H
#define OST_HAPTICS_NEWEST_H

#include <stdatomic.h>
#include <stdbool.h>

enum { NEWEST_SLOTS = 3, NEWEST_FRESH = 4 };

typedef struct newest {
    /* index of the slot that is exchanged; NEWEST_FRESH is set until the reader takes the slot */
    _Atomic unsigned char middle;
    unsigned char back;           /* slot of the writer */
    unsigned char front;          /* slot of the reader */
} newest;

static inline void newest_begin(newest *n)
{
    atomic_init(&n->middle, 1);
    n->back = 0;
    n->front = 2;
}

/* Publishes the slot n->back, which the writer has filled. Sets n->back to another slot. */
static inline void newest_put(newest *n)
{
    n->back = atomic_exchange_explicit(&n->middle, (unsigned char)(n->back | NEWEST_FRESH), memory_order_acq_rel) & 3;
}

/*
 * Takes the newest value. After the call, slot n->front contains this value. Returns true if the value was not taken
 * before.
 */
static inline bool newest_take(newest *n)
{
    if (!(atomic_load_explicit(&n->middle, memory_order_relaxed) & NEWEST_FRESH))
        return false;
    n->front = atomic_exchange_explicit(&n->middle, n->front, memory_order_acq_rel) & 3;
    return true;
}

#endif
