/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes shades from fields. The slopes are read point by point and then converted to shades, sixteen points at a
 * time if the registers are wide enough. Float operations have a fixed order, and each is rounded separately. Let
 * `fine` and `wide` be the slopes of the fine and of the wide field at a voxel, and f and w the values of these fields:
 *
 *   angle between fine and wide                           --> t, the share of wide
 *   (1 - t) fine / |fine| + t wide / |wide|               --> normal
 *   (1 - t) openness from f + t openness from 2 w - f     --> openness
 *
 * The value of a field at a voxel depends on two quantities: the openness of the voxel, and its distance from the
 * smooth surface. Across a plane, w rises half as fast as f, so 2 w - f is independent of the voxel's distance: it is
 * half of the maximum on a plane, less on an edge, and more in a hollow.
 */
#ifndef OST_RENDER_SLOPES_H
#define OST_RENDER_SLOPES_H

#include "render/points/octahedral.h"
#include "render/points/smooth.h"

enum {
    /* bit at which a line begins in the word of a row: bit 0 is x = -16, and a line begins at x = -8 */
    OST_LINE_SHIFT = 8,
    /* index in a line at which the first sum begins. The first entry of a field row is at x = -1, so its sum of nine
     * voxels begins at x = -5 */
    OST_LINE_SKIP = 3,
    OST_SLOPES = 16,
    /* PLANE: openness of a plane; LEAST: minimum openness; PIT, EDGE: rates at which openness falls in a pit and rises
     * on an edge */
    OST_OPEN_PLANE = 225, OST_OPEN_LEAST = 40, OST_OPEN_PIT = 470, OST_OPEN_EDGE = 120,
    OST_WIDE_PART = 4,   /* divisor of the wide field's values */
    OST_WIDE_LEAST = 120, /* a wide slope below this length is ignored */
    OST_WIDE_PLANE = OST_FIELD_FULL / 10, /* OST_FIELD_FLAT minus half of OST_FIELD_FULL */
};
/*
 * Let c be the cosine of the angle between the fine and the wide slope. The weight of the wide slope is 0 for c <=
 * OST_AGREE_LEAST. For greater c, it rises by OST_AGREE_STEEP per unit of c, up to 1.
 */
static const float OST_AGREE_LEAST = 0.6f, OST_AGREE_STEEP = 10;

/* Returns the openness for a value of the field, which is from 0 to slightly more than OST_FIELD_FULL. */
static inline int ost_openness(int field)
{
    const int beyond = field - OST_FIELD_FLAT;
    const int open = OST_OPEN_PLANE - beyond * (beyond > 0 ? OST_OPEN_PIT : OST_OPEN_EDGE) / OST_FIELD_FULL;
    return open < OST_OPEN_LEAST ? OST_OPEN_LEAST : open > 255 ? 255 : open;
}

/*
 * Data of up to OST_SLOPES points: slopes of the fine and of the wide field along each axis, values of both fields, and
 * exposed faces.
 */
typedef struct ost_slopes {
    int32_t fine[3][OST_SLOPES], wide[3][OST_SLOPES], value[2][OST_SLOPES], faces[OST_SLOPES];
} ost_slopes;

static inline int32_t ost_slope_of(const ost_field_slice *const slice[3], uint32_t x, uint32_t y, int i,
                                   int32_t out[3][OST_SLOPES])
{
    const uint16_t *at = &(*slice[1])[y][x];
    out[0][i] = at[-1] - at[1];
    out[1][i] = at[-OST_FIELD_LINE] - at[OST_FIELD_LINE];
    out[2][i] = (*slice[0])[y][x] - (*slice[2])[y][x];
    return at[0];
}

static inline void ost_slope_at(uint32_t point, const ost_field_slice *const fine[3],
                                const ost_field_slice *const wide[3], ost_slopes *out, int i)
{
    const uint32_t x = (point & 31) + 1, y = (point >> 5 & 31) + 1;
    out->value[0][i] = ost_slope_of(fine, x, y, i, out->fine);
    out->value[1][i] = ost_slope_of(wide, x, y, i, out->wide);
    out->faces[i] = (int32_t)(point >> OST_FACES_SHIFT);
}

/* Adds the contribution of the exposed faces to a slope. Without it, the slope would be zero in the middle of a plate
   that is one voxel thick. */
static inline int32_t ost_slope_with_faces(int32_t slope, int32_t faces, int axis)
{
    return slope + OST_FIELD_BY_FACES * ((faces >> (2 * axis + 1) & 1) - (faces >> (2 * axis) & 1));
}

/* Computes the slopes of up to OST_SLOPES points. */
static inline void ost_slopes_at(const uint32_t *points, int count, const ost_field_slice *const fine[3],
                                 const ost_field_slice *const wide[3], ost_slopes *out)
{
    for (int i = 0; i < count && i < OST_SLOPES; i++)
        ost_slope_at(points[i], fine, wide, out, i);
}

#endif
