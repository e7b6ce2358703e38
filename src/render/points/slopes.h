/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From fields to looks: slopes are fetched point by point, then turned into
 * words, sixteen points together where there are registers for it.  Floats,
 * each operation rounded by itself and in one order:
 *
 *   fine, wide slope --their angle--> share t of the wide one
 *   (1 - t) fine / |fine| + t wide / |wide| --> normal
 *   fine, wide value --> openness by the fine one, by both --t--> openness
 *
 * The value tells how far a voxel lies off the smooth surface as well as how
 * open it lies.  Across a plane the wide one rises half as fast as the fine
 * one, so in 2 wide - fine the first is gone: half of all, wherever the voxel
 * lies; less on an edge, more in a hollow.
 */
#ifndef OST_RENDER_SLOPES_H
#define OST_RENDER_SLOPES_H

#include "render/points/octahedral.h"
#include "render/points/smooth.h"

enum {
    OST_LINE_SHIFT = 8,  /* bit of a row that a line begins with */
    OST_LINE_SKIP = 3,   /* a field's row begins at x = -1, the sum there at x = -5 */
    OST_SLOPES = 16,
    OST_OPEN_PLANE = 225, OST_OPEN_LEAST = 40, OST_OPEN_PIT = 470, OST_OPEN_EDGE = 120, /* openness; how fast it falls, rises */
    OST_WIDE_PART = 4,   /* a wide value is such a part of the field's */
    OST_WIDE_LEAST = 120, /* a wide slope that is less says nothing */
    OST_WIDE_PLANE = OST_FIELD_FULL / 10, /* from half of all to what OST_FIELD_FLAT is */
};
static const float OST_AGREE_LEAST = 0.6f, OST_AGREE_STEEP = 10; /* cosine from which on the wide slope counts; 1 / 10 more and it alone does */

/* Of a field value, 0 to about OST_FIELD_FULL, and a little beyond. */
static inline int ost_openness(int field)
{
    const int beyond = field - OST_FIELD_FLAT;
    const int open = OST_OPEN_PLANE - beyond * (beyond > 0 ? OST_OPEN_PIT : OST_OPEN_EDGE) / OST_FIELD_FULL;
    return open < OST_OPEN_LEAST ? OST_OPEN_LEAST : open > 255 ? 255 : open;
}

/* Of points: how much more of the bone is before than behind, by each field; the fields; faces to the air. */
typedef struct ost_slopes {
    int32_t fine[3][OST_SLOPES], wide[3][OST_SLOPES], value[2][OST_SLOPES], faces[OST_SLOPES];
} ost_slopes;

static inline int32_t ost_slope_of(const ost_field_slice *const slice[3], uint32_t x, uint32_t y, int i, int32_t out[3][OST_SLOPES])
{
    const uint16_t *at = &(*slice[1])[y][x];
    out[0][i] = at[-1] - at[1];
    out[1][i] = at[-OST_FIELD_LINE] - at[OST_FIELD_LINE];
    out[2][i] = (*slice[0])[y][x] - (*slice[2])[y][x];
    return at[0];
}

static inline void ost_slope_at(uint32_t point, const ost_field_slice *const fine[3], const ost_field_slice *const wide[3], ost_slopes *out, int i)
{
    const uint32_t x = (point & 31) + 1, y = (point >> 5 & 31) + 1;
    out->value[0][i] = ost_slope_of(fine, x, y, i, out->fine);
    out->value[1][i] = ost_slope_of(wide, x, y, i, out->wide);
    out->faces[i] = (int32_t)(point >> OST_FACES_SHIFT);
}

/* In the middle of a plate as thin as a voxel the field has no slope; there the open faces decide. */
static inline int32_t ost_slope_with_faces(int32_t slope, int32_t faces, int axis)
{
    return slope + OST_FIELD_BY_FACES * ((faces >> (2 * axis + 1) & 1) - (faces >> (2 * axis) & 1));
}

/* Slopes of up to OST_SLOPES points. */
static inline void ost_slopes_at(const uint32_t *points, int count, const ost_field_slice *const fine[3], const ost_field_slice *const wide[3],
                                 ost_slopes *out)
{
    for (int i = 0; i < count && i < OST_SLOPES; i++)
        ost_slope_at(points[i], fine, wide, out, i);
}

#endif
