/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Iterates over the runs of set bits in an array of words, beginning with the lowest bit of the first word.  The
 * headers render/points/cells.h and window/changed.h use this iterator to process parts of a picture.
 */
#ifndef OST_CORE_BITS_RUN_H
#define OST_CORE_BITS_RUN_H

#include <stdbool.h>
#include <stdint.h>

/* Sets [*from, *to) to the next run of set bits at or after *to. Returns false if there is no further run. */
static inline bool ost_bits_run(const uint64_t *word, int words, int *from, int *to)
{
    int i = *to;
    for (; i < 64 * words; i = (i / 64 + 1) * 64) {
        const uint64_t left = word[i / 64] >> (i % 64);
        if (left) {
            i += __builtin_ctzll(left);
            break;
        }
    }
    *from = i;
    for (; i < 64 * words; i = (i / 64 + 1) * 64) {
        const uint64_t left = ~word[i / 64] >> (i % 64);
        if (left) {
            i += __builtin_ctzll(left);
            break;
        }
    }
    *to = i < 64 * words ? i : 64 * words;
    return *from < 64 * words;
}

#endif
