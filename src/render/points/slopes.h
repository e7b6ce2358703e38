/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a field to looks: slopes are fetched point by point, then sixteen points
 * are turned into words together, by the operations of octahedral.h, each
 * rounded by itself.
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
};

/* Of a field value, 0 to about OST_FIELD_FULL. */
static inline uint32_t ost_openness(int field)
{
    const int beyond = field - OST_FIELD_FLAT;
    const int open = OST_OPEN_PLANE - beyond * (beyond > 0 ? OST_OPEN_PIT : OST_OPEN_EDGE) / OST_FIELD_FULL;
    return (uint32_t)(open < OST_OPEN_LEAST ? OST_OPEN_LEAST : open > 255 ? 255 : open);
}

/* Of points: how much more of the bone is before than behind, the field itself, faces to the air. */
typedef struct ost_slopes {
    int32_t out[3][OST_SLOPES], field[OST_SLOPES], faces[OST_SLOPES];
} ost_slopes;

static inline void ost_slope_at(uint32_t point, const ost_field_slice *const slice[3], ost_slopes *out, int i)
{
    const uint32_t x = (point & 31) + 1, y = (point >> 5 & 31) + 1;
    const uint16_t *at = &(*slice[1])[y][x];
    out->out[0][i] = at[-1] - at[1];
    out->out[1][i] = at[-OST_FIELD_LINE] - at[OST_FIELD_LINE];
    out->out[2][i] = (*slice[0])[y][x] - (*slice[2])[y][x];
    out->field[i] = at[0];
    out->faces[i] = (int32_t)(point >> OST_FACES_SHIFT);
}

/* In the middle of a plate as thin as a voxel the field has no slope; there the open faces decide. */
static inline int32_t ost_slope_with_faces(int32_t slope, int32_t faces, int axis)
{
    return slope + OST_FIELD_BY_FACES * ((faces >> (2 * axis + 1) & 1) - (faces >> (2 * axis) & 1));
}

/* Slopes of up to OST_SLOPES points. */
static inline void ost_slopes_at(const uint32_t *points, int count, const ost_field_slice *const slice[3], ost_slopes *out)
{
    for (int i = 0; i < count && i < OST_SLOPES; i++)
        ost_slope_at(points[i], slice, out, i);
}

#endif
