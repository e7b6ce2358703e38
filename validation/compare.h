/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Two traces of the same cases, compared by memcmp, record by record.
 *
 *   reference's trace, another's --compare_case--> equal, or the first
 *   difference: stage, item, word or voxel, and both values
 *
 * The first difference is the first in the order of the stages, so what comes
 * after it may be its consequence and is not counted as anything else.  A leaf
 * that only one side changed at a tick is compared with what it was before on
 * the other, which an earlier record holds.
 */
#ifndef OST_VALIDATION_COMPARE_H
#define OST_VALIDATION_COMPARE_H

#include "validation/trace.h"

typedef enum compare_kind {
    COMPARE_EQUAL,
    COMPARE_VOXEL,   /* voxels differ */
    COMPARE_WORD,    /* only what was reported differs */
    COMPARE_SHAPE,   /* blocks or words are not the same ones */
    COMPARE_MISSING  /* the other's trace has no such record */
} compare_kind;

typedef struct compare_difference {
    compare_kind kind;
    trace_stage stage;
    uint32_t item;         /* tool or tick */
    size_t word;           /* of COMPARE_WORD */
    uint64_t line_words;   /* in a chunk's line of this record's report; 0 where it has no lines */
    uint64_t word_ref, word_got;
    int32_t voxel[3];      /* of COMPARE_VOXEL: the first in x-fastest order over the whole grid */
    int32_t voxel_ref, voxel_got;
    uint64_t voxels;       /* that differ in this record; of a tick those in leaves that this tick changed on either side */
    uint64_t records;      /* of this case that were compared, this one included */
    bool words_too;        /* of COMPARE_VOXEL: the report differs as well */
    int64_t chunk;         /* the bone's chunk that the report first differs in; -1 where no chunk's line does */
} compare_difference;

/* Where a case's records lie in a trace; count 0: it has none. */
typedef struct compare_range {
    size_t first, count;
} compare_range;

compare_range compare_find(const trace *t, uint32_t case_index);
/* Record `at` of both alone; COMPARE_EQUAL too where one has none. */
void compare_record_at(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at, compare_difference *out);
/* The same for one case after the other: *at is 0 at first, and then where the last one ended. */
compare_range compare_next(const trace *t, size_t *at, uint32_t case_index);
void compare_case(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, compare_difference *out);

#endif
