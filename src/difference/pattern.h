/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Classifies the difference between two grids.
 *
 *   two grids, and their inputs if known --> patterns that hold --> class: the first pattern that holds
 *
 * Every rule is a statement that is checked on all voxels to which it applies, so a pattern that holds is
 * certain. The cause of the difference is not certain; the class indicates where to search first. If
 * several patterns hold, the class is the first of them in the list below. The list begins with the patterns
 * that describe a difference most precisely. D is the set of differing voxels, A is the reference's grid, and
 * B is the other grid.
 *
 *   byte-order      every voxel of D is the correct value with its two bytes swapped
 *   axis-swap       B is A with axes exchanged or reversed, or memory was read with the axes in a different order
 *   shift           B is A moved by a few voxels; or every voxel of D has the value of its neighbour in the same
 *                   direction; or every voxel of D was resampled from input voxels whose index is off by one
 *   row-pitch       D has the values that would be read if rows in memory were longer or shorter than they are
 *   offset          all densities of D differ by the same amount
 *   threshold       one grid lacks exactly the voxels below a certain density, as if its threshold were higher
 *   stale-chunk     in every chunk with a difference, B equals the bone before the event, although the
 *                   reports are the same
 *   lost-tail       D is the end of the work (the last samples, voxels or chunks), which was not done
 *   lost-chunk      every chunk with a difference is completely empty or unprocessed
 *   column-parity   D consists of complete runs of voxels along x, from one crossing of the surface to another
 *   tool-class      every voxel of D is solid in both grids and cutting in only one of them
 *   boundary-layer  D lies on the surface, one voxel deep
 *   carried-rows    every row of D is the correct row combined with the previous row, whose counts were not
 *                   cleared
 *   speckle         most voxels of D have no neighbour in D
 *   unclassified    none of these patterns holds
 *
 * `osteon diff` and the campaign use the same rules. The campaign has more inputs, such as the bone before the
 * event, and can therefore distinguish more patterns.
 */
#ifndef OST_DIFFERENCE_PATTERN_H
#define OST_DIFFERENCE_PATTERN_H

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

const char *ost_pattern_name(pattern p);

/* The relation between the grid and `in`, the input from which the stage made the grid. */
typedef enum pattern_input {
    PATTERN_NO_INPUT,
    /* `in` is resampled: voxel (x, y, z) is voxel (source[0][x], source[1][y], source[2][z]) of `in`, or a mean of that
       voxel and its upper neighbours */
    PATTERN_SOURCE,
    PATTERN_THRESHOLDED, /* `in` is the same grid before densities below the threshold were set to 0 */
    PATTERN_BEFORE       /* `in` is the bone before the event */
} pattern_input;

enum { PATTERN_WEIGHT_ONE = 1 << 15 }; /* sum of the two weights on each axis */

typedef struct pattern_view {
    const int16_t *a, *b;
    ost_dims dims, dims_b;    /* dims of the grids A and B; if they differ, only axis-swap is checked */
    int32_t solid_a, solid_b; /* lowest density or class of a solid voxel */
    bool tool;
    int chunk;                /* edge length of a chunk in voxels */
    pattern_input input;
    const int16_t *in;
    ost_dims in_dims;
    const int32_t *source[3];
    /* for each axis, the weight of the voxel that follows the source voxel, in units of 1 / PATTERN_WEIGHT_ONE; if the
       weight is 0, that voxel is not read */
    const int32_t *weight[3];
    /* for each voxel, the number of samples after the voxel's last sample in the same batch, or -1 if the voxel has no
       sample; NULL if these numbers are unknown */
    const int32_t *behind;
    bool reported_too;        /* true if the report also differs */
} pattern_view;

enum { PATTERN_TEXT = 200 };
typedef struct pattern_list {
    bool holds[PATTERNS];
    char text[PATTERNS][PATTERN_TEXT]; /* evidence for each pattern that holds, in the order of the patterns */
    pattern of_all;                    /* class of the difference */
} pattern_list;

/* Checks all patterns. The two grids must differ in their dims or in at least one voxel. */
void ost_pattern_find(const pattern_view *view, pattern_list *out);

#endif
