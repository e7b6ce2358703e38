/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declares the rules of pattern.h and the helper functions that several rules use. D is the set of
 * differing voxels.
 *
 *   pattern.c        D, values, the list     pattern_place.c   positions
 *   pattern_chunk.c  chunks, tails           pattern_shape.c   rows, surface, neighbours
 */
#ifndef OST_DIFFERENCE_PATTERN_PARTS_H
#define OST_DIFFERENCE_PATTERN_PARTS_H

#include "difference/pattern.h"

/* Minimum number of voxels for which a pattern is significant. */
enum { PATTERN_TELLING = 8 };

/* The input of all rules: the grids (`v`), and the properties of D, the set of differing voxels. */
typedef struct pattern_scan {
    const pattern_view *v;
    int64_t count;         /* number of voxels in D */
    int64_t first;         /* lowest index of a voxel in D */
    int32_t lo[3], hi[3];  /* bounds of D as a half-open box */
    bool several;          /* true if B has more than one non-zero value in D */
} pattern_scan;

/* Returns true and writes the evidence to `text` if the pattern holds. */
typedef bool pattern_rule(const pattern_scan *s, char *text);

/* pattern_place.c */
pattern_rule ost_pattern_axis_swap, ost_pattern_shift, ost_pattern_row_pitch;
/* pattern_chunk.c */
pattern_rule ost_pattern_stale_chunk, ost_pattern_lost_tail, ost_pattern_lost_chunk;
/* pattern_shape.c */
pattern_rule ost_pattern_column_parity, ost_pattern_tool_class, ost_pattern_boundary_layer, ost_pattern_carried_rows,
    ost_pattern_speckle;

/* Writes the evidence to text. Always returns true. */
bool ost_pattern_describe(char *text, const char *format, ...) OST_PRINTF(2, 3);

/* Converts a density to the form in which the stage stores it. */
int16_t ost_pattern_stored(const pattern_view *v, int16_t density);

static inline bool pattern_same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static inline int64_t pattern_at(ost_dims d, int64_t x, int64_t y, int64_t z)
{
    return x + d.x * (y + d.y * z);
}

static inline bool pattern_inside(ost_dims d, int64_t x, int64_t y, int64_t z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z;
}

/* Iterates over the differing voxels; p is the position of the voxel, i its index. */
#define PATTERN_EACH(s, p, i)                                                                                          \
    for (int32_t p[3] = {0, 0, (s)->lo[2]}; p[2] < (s)->hi[2]; p[2]++)                                                 \
        for (p[1] = (s)->lo[1]; p[1] < (s)->hi[1]; p[1]++)                                                             \
            for (int64_t i = pattern_at((s)->v->dims, p[0] = (s)->lo[0], p[1], p[2]); p[0] < (s)->hi[0]; p[0]++, i++)  \
                if ((s)->v->a[i] != (s)->v->b[i])

#endif
