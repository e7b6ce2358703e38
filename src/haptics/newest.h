/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The newest value from one thread to another, wait-free on both sides: three
 * slots, of which the writer has one, the reader one, and one lies between
 * them.
 *
 *   writer: back --exchange--> middle --exchange--> front :reader
 *
 * A value that was not taken before the next came is gone; that is the point.
 */
#ifndef OST_HAPTICS_NEWEST_H
#define OST_HAPTICS_NEWEST_H

#include <stdatomic.h>
#include <stdbool.h>

enum { NEWEST_SLOTS = 3, NEWEST_FRESH = 4 };

typedef struct newest {
    _Atomic unsigned char middle; /* a slot's number, and NEWEST_FRESH until it is taken */
    unsigned char back;           /* the writer's */
    unsigned char front;          /* the reader's */
} newest;

static inline void newest_begin(newest *n)
{
    atomic_init(&n->middle, 1);
    n->back = 0;
    n->front = 2;
}

/* The writer has filled slot n->back; now it has another one. */
static inline void newest_put(newest *n)
{
    n->back = atomic_exchange_explicit(&n->middle, (unsigned char)(n->back | NEWEST_FRESH), memory_order_acq_rel) & 3;
}

/* True when slot n->front holds a value that was not there before. */
static inline bool newest_take(newest *n)
{
    if (!(atomic_load_explicit(&n->middle, memory_order_relaxed) & NEWEST_FRESH))
        return false;
    n->front = atomic_exchange_explicit(&n->middle, n->front, memory_order_acq_rel) & 3;
    return true;
}

#endif
