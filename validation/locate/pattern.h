/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a difference between two grids looks like.
 *
 *   two grids, and what is known about where they come from --> patterns that hold --> class: the first of them
 *
 * Every rule is a statement that is checked on all voxels it speaks of, so it
 * is a fact; that the fact names the cause is not: the class says what to look
 * at first.  Several may hold; their order below is that of the class, from
 * what explains most to what explains least.  D is the set of voxels that
 * differ, A the reference's grid, B the other's.
 *
 *   byte-order      every voxel of D is the right one with its two bytes swapped
 *   axis-swap       B is A with axes exchanged or turned round, or memory read in another order of the axes
 *   shift           every voxel of D is its neighbour's, the same way for all, or another voxel was resampled
 *   row-pitch       D is what lies there if rows in memory are longer or shorter than they are
 *   offset          all densities of D differ by the same amount
 *   threshold       D is all that lies on one side of a density near the threshold
 *   stale-chunk     in every chunk with a difference B is as before the event, and reported otherwise
 *   lost-tail       D is the end of what was to be done, and undone: samples, voxels or chunks
 *   lost-chunk      every chunk with a difference is void or undone as a whole
 *   column-parity   D are whole runs of voxels along x, from one crossing of the surface to another
 *   tool-class      every voxel of D is solid in both: one has it cutting, the other not
 *   boundary-layer  D lies on the surface, one voxel deep
 *   carried-rows    every row of D is what the row before it and its own make together: what a row had went on into the next
 *   speckle         most voxels of D have no neighbour in D
 *   unclassified    none of these
 *
 * osteon diff and the campaign ask the same rules; the campaign knows more,
 * such as the bone before the event, and can so tell more.
 */
#ifndef OST_VALIDATION_PATTERN_H
#define OST_VALIDATION_PATTERN_H

#include <osteon/grid.h>

typedef enum pattern {
    PATTERN_BYTE_ORDER,
    PATTERN_AXIS_SWAP,
    PATTERN_SHIFT,
    PATTERN_ROW_PITCH,
    PATTERN_OFFSET,
    PATTERN_THRESHOLD,
    PATTERN_STALE_CHUNK,
    PATTERN_LOST_TAIL,
    PATTERN_LOST_CHUNK,
    PATTERN_COLUMN_PARITY,
    PATTERN_TOOL_CLASS,
    PATTERN_BOUNDARY_LAYER,
    PATTERN_CARRIED_ROWS,
    PATTERN_SPECKLE,
    PATTERN_UNCLASSIFIED,
    PATTERNS
} pattern;

const char *pattern_name(pattern p);

/* What the stage made its grid from, where that is known. */
typedef enum pattern_input {
    PATTERN_NO_INPUT,
    PATTERN_SOURCE,      /* in is resampled: voxel (x, y, z) is in's (source[0][x], source[1][y], source[2][z]), or a mean with the next */
    PATTERN_THRESHOLDED, /* in is the same grid before densities below the threshold became 0 */
    PATTERN_BEFORE       /* in is the bone before the event */
} pattern_input;

typedef struct pattern_view {
    const int16_t *a, *b;
    ost_dims dims, dims_b;    /* only axis-swap is asked where they differ */
    int32_t solid_a, solid_b; /* a voxel is solid from this value on */
    bool tool;
    int chunk;                /* chunks' width */
    pattern_input input;
    const int16_t *in;
    ost_dims in_dims;
    const int32_t *source[3];
    const int32_t *weight[3]; /* of the next along each axis, in 2^-15; 0: it is not read */
    const int32_t *behind;    /* per voxel: samples after its last one in the batch, -1 without a sample; NULL: not known */
    bool reported_too;        /* the report differs as well */
} pattern_view;

enum { PATTERN_TEXT = 200 };
typedef struct pattern_list {
    bool holds[PATTERNS];
    char text[PATTERNS][PATTERN_TEXT]; /* for people, of those that hold */
    pattern of_all;                    /* the class */
} pattern_list;

/* Some voxel must differ, or the dims. */
void pattern_find(const pattern_view *view, pattern_list *out);

#endif
