/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Classifies the difference between two grids.
 *
 *   two grids and, optionally, the bone before an event --> patterns that hold --> class of the first pattern
 *
 * Every pattern is a statement that is checked on all voxels to which it applies, so a pattern that holds is certain.
 * The cause of the difference is not certain; the class indicates where to search first. `osteon diff` and
 * `osteon validate` use the same patterns, and docs/design/validation.md lists them.
 *
 * Threads: the function has no state; volumes that are passed as const may be shared.
 */
#ifndef OSTEON_DIFFERENCE_H
#define OSTEON_DIFFERENCE_H

#include <osteon/event.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Options of ost_difference_find. A zero-initialised struct selects the defaults. */
typedef struct ost_difference_options {
    int32_t threshold_a, threshold_b; /* lowest density of a solid voxel in each grid; 0 selects 120, or 1 for a tool */
    bool tool;                /* true if the voxels are the classes of a tool (tool.h) */
    int chunk_size;           /* 16, 32 or 64; 0 selects 32 */
    /* The bone before the event that made both grids, or NULL. Its dims must be those of grid `a`. */
    const ost_volume *before;
    bool report_differs;      /* true if the reports of the event differ too */
} ost_difference_options;

enum { OST_DIFFERENCE_TEXT = 200, OST_DIFFERENCE_PATTERNS_MAX = 16 };

/* A pattern that holds. */
typedef struct ost_difference_pattern {
    const char *name;               /* static, for example "boundary-layer" */
    char text[OST_DIFFERENCE_TEXT]; /* the evidence: a sentence in which the grids are named A and B */
} ost_difference_pattern;

/* The difference between two grids. */
typedef struct ost_difference {
    int64_t voxels;         /* number of voxels that differ; 0 if the dims differ */
    ost_voxel_box box;      /* box that encloses these voxels; empty if there are none */
    const char *class_name; /* name of the class, "unclassified" if no pattern holds; NULL if the grids are equal */
    int pattern_count;
    /* the patterns that hold; the first pattern determines the class */
    ost_difference_pattern patterns[OST_DIFFERENCE_PATTERNS_MAX];
} ost_difference;

/*
 * Classifies the difference between two grids. The voxels of `a` are assumed to be correct. Spacing and origin are not
 * compared. If the dims differ, axis-swap is the only pattern that is checked. Returns OST_ERR_USAGE if a volume has no
 * voxels, if the dims of `before` differ from those of `a`, or if the chunk size is not 16, 32 or 64. Returns
 * OST_ERR_RANGE if a threshold is not within 0 to 32767.
 */
OST_API ost_status ost_difference_find(const ost_volume *a, const ost_volume *b, const ost_difference_options *options,
                                       ost_difference *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
