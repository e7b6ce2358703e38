/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/blocks.h"

#include <math.h>
#include <stdlib.h>

/* Maximum distance of the eye in voxels. Up to this distance, two adjacent voxels near the view axis have squared
   distances that are different floats. */
static const float FARTHEST = 32768.0f;

ost_status ost_blocks_check(const ost_surface *surface, const ost_eye *eye, ost_error *err)
{
    const ost_dims d = surface->geometry.dims;
    const float size[3] = {(float)d.x, (float)d.y, (float)d.z};
    for (int a = 0; a < 3; a++)
        if (!(fabsf(eye->at[a]) < FARTHEST) || !(fabsf(eye->at[a] - size[a]) < FARTHEST))
            return ost_fail(err, OST_ERR_RANGE, "the camera is more than %d voxels away from the bone; move it closer",
                            (int)FARTHEST);
    return OST_OK;
}

/* Computes the half-open range of pixels in 0 .. count - 1 that intersect the interval [p - h, p + h]. */
static void range(float p, float h, int count, int *from, int *to)
{
    *from = p - h > 0 ? (int)(p - h) : 0;
    *to = p + h < (float)(count - 1) ? (int)(p + h) + 1 : count;
}

/*
 * Treats the cube as one large voxel; splat_scalar.c derives the slopes. The range includes one additional pixel on
 * each side to allow for rounding.
 */
bool ost_blocks_pixels(const ost_splat_eye *s, const float o[3], int side, ost_extent *out)
{
    const ost_eye *e = &s->eye;
    const float half = (float)side; /* `side` is not halved, because s->reach is half the width of a voxel */
    const float x = ost_eye_dot(e->right, o), y = ost_eye_dot(e->up, o), z = ost_eye_dot(e->forward, o);
    const float reach = half * s->reach[2], far = z + reach, nearest = z - reach;
    if (!(far > e->near))
        return false;
    *out = (ost_extent){0, e->width, 0, e->height};
    if (!(nearest > e->near))
        return true;
    const float tx = x / z, ty = y / z;
    float sx = 0, sy = 0;
    for (int a = 0; a < 3; a++) {
        sx += fabsf(e->right[a] - tx * e->forward[a]);
        sy += fabsf(e->up[a] - ty * e->forward[a]);
    }
    const float k = 0.5f * half * e->focal / nearest;
    const float px = e->half_w + tx * e->focal, py = e->half_h - ty * e->focal, hx = sx * k + 1, hy = sy * k + 1;
    if (px + hx < 0 || px - hx > (float)e->width || py + hy < 0 || py - hy > (float)e->height)
        return false;
    range(px, hx, e->width, &out->x0, &out->x1);
    range(py, hy, e->height, &out->y0, &out->y1);
    return true;
}

/*
 * Returns a lower bound on the keys of a block's voxels, with a margin for rounding. `base` is the vector from the eye
 * to the block's voxel (0, 0, 0).
 */
static uint64_t nearest_key(const float base[3])
{
    float square = 0;
    for (int a = 0; a < 3; a++) {
        const float before = base[a], behind = -(base[a] + (float)(OST_BLOCK - 1)),
                    off = before > behind ? before : behind;
        square += off > 0 ? off * off : 0;
    }
    return ost_key(0.9999f * square, 0);
}

static int by_distance(const void *a, const void *b)
{
    const ost_frame_block *x = a, *y = b;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->slot - y->slot;
}

void ost_blocks_choose(const ost_surface *s, const ost_splat_eye *eye, ost_frame_block *blocks, float *bases,
                       int32_t *count, int *y0, int *y1)
{
    const ost_eye *e = &eye->eye;
    int32_t n = 0;
    *y0 = *y1 = 0;
    for (int32_t i = 0; i < s->used; i++) {
        const ost_surface_block *block = s->slot[i];
        ost_frame_block b = {.slot = i, .count = block->count};
        float middle[3];
        for (int a = 0; a < 3; a++) {
            bases[4 * i + a] = (float)(OST_BLOCK * block->at[a]) - e->at[a];
            middle[a] = bases[4 * i + a] + 15.5f;
        }
        if (block->count == 0 || !ost_blocks_pixels(eye, middle, OST_BLOCK, &b.pixels))
            continue;
        b.distance = ost_eye_dot(middle, middle);
        b.nearest = nearest_key(&bases[4 * i]);
        blocks[n++] = b;
        *y0 = n == 1 || b.pixels.y0 < *y0 ? b.pixels.y0 : *y0;
        *y1 = n == 1 || b.pixels.y1 > *y1 ? b.pixels.y1 : *y1;
    }
    if (n > 0)
        qsort(blocks, (size_t)n, sizeof *blocks, by_distance);
    *count = n;
}

void ost_blocks_turned(float base, int axis, uint8_t turned[OST_BLOCK])
{
    for (int i = 0; i < OST_BLOCK; i++) {
        const float o = base + (float)i;
        turned[i] = (uint8_t)((o > OST_HALF) << (2 * axis) | (o < -OST_HALF) << (2 * axis + 1));
    }
}
