/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares two traces of the same cases by memcmp, record by record.
 *
 *   reference's trace, another's --compare_case--> equal, or the first
 *   difference: stage, item, word or voxel, and both values
 *
 * The stages are compared in their order. Differences after the first one may be its consequences and are not
 * counted separately. If only one of the two backends changed a leaf at a tick, the leaf is compared with its
 * state in the latest earlier record of the other backend.
 */
#ifndef OST_VALIDATION_COMPARE_H
#define OST_VALIDATION_COMPARE_H

#include "validation/trace.h"

typedef enum compare_kind {
    COMPARE_EQUAL,
    COMPARE_VOXEL,   /* voxels differ */
    COMPARE_WORD,    /* the voxels are equal, but words of the reports differ */
    /* The types of the records differ, or one trace has an additional record or an additional block. */
    COMPARE_SHAPE,
    /* the other trace ends before this record of the reference, or has a failed stage in place of this record */
    COMPARE_MISSING
} compare_kind;

typedef struct compare_difference {
    compare_kind kind;
    trace_stage stage;
    uint32_t item;         /* index of the tool or of the tick to which the record belongs */
    size_t word;           /* COMPARE_WORD: index of the first word that differs */
    /* number of words per chunk in this record's report; 0 if the report has no lines for chunks */
    uint64_t line_words;
    uint64_t word_ref, word_got;
    int32_t voxel[3];      /* COMPARE_VOXEL: the first voxel that differs, in x-fastest order over the entire grid */
    int32_t voxel_ref, voxel_got;
    /* number of differing voxels in this record; for a tick, only voxels in leaves that changed on at least one backend
       are counted */
    uint64_t voxels;
    uint64_t records;      /* number of compared records of this case, including the record with the difference */
    bool words_too;        /* COMPARE_VOXEL: true if words of the report differ too */
    int64_t chunk;         /* number of the first chunk whose line in the report differs; -1 if there is none */
} compare_difference;

/* Range of a case's records in a trace; count is 0 if the case has no records. */
typedef struct compare_range {
    size_t first, count;
} compare_range;

compare_range compare_find(const trace *t, uint32_t case_index);
/* Compares only the records with index `at` of both ranges. The result is COMPARE_EQUAL if one of the ranges has no
   record with this index. */
void compare_record_at(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
                       compare_difference *out);
/* Finds the records of a case. The search begins at record *at, which is 0 for the first case; if records are found,
   *at is set to the first record after them. The cases must be passed in the order of the trace. */
compare_range compare_next(const trace *t, size_t *at, uint32_t case_index);
void compare_case(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                  compare_difference *out);

#endif
