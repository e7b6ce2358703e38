/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One voxel, whose centre is o from the eye:
 *
 *   in the camera's frame    x = o . right, y = o . up, z = o . forward
 *   tx = x / z               the slope of its centre; of a corner it is within
 *                            s / (z - reach) with s = 1/2 sum |right - tx forward|,
 *                            since x' - t z' = (x - t z) + (their half widths) <= 0
 *                            holds for all corners once t - tx >= s / (nearest z)
 *   rectangle                from those slopes, a hundredth of a pixel wider
 *   covered                  |o x d|_x <= 1/2 (|d_y| + |d_z|), and so for y and z:
 *                            the line along d meets the cube about o
 *
 * o x d is linear in the pixel's coordinates.  A voxel of which a corner is not
 * beyond the near plane is not drawn: then lines are rays.
 */
#include "core/conditions.h"
#include "render/points/splat.h"

#include <math.h>

ost_splat_eye ost_splat_prepare(const ost_eye *eye)
{
    ost_splat_eye s = {.eye = *eye};
    const float *frame[3] = {eye->right, eye->up, eye->forward};
    for (int a = 0; a < 3; a++) {
        s.axis[0][a] = eye->focal * eye->forward[a];
        s.axis[1][a] = eye->right[a];
        s.axis[2][a] = eye->up[a];
        s.reach[a] = OST_HALF * ((fabsf(frame[a][0]) + fabsf(frame[a][1])) + fabsf(frame[a][2]));
    }
    return s;
}

uint32_t ost_facing_scalar(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], uint32_t *id, uint32_t *look)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        const uint32_t p = block->points[i];
        const uint32_t seen = (uint32_t)(turned[0][p & 31] | turned[1][p >> 5 & 31] | turned[2][p >> 10 & 31]);
        id[n] = slot << OST_LOCAL_BITS | (p & ((1u << OST_LOCAL_BITS) - 1));
        look[n] = block->looks[i];
        n += (p >> OST_FACES_SHIFT & seen) != 0;
    }
    return n;
}

typedef struct rectangle {
    int x0, x1, y0, y1; /* pixels, x1 and y1 among them */
} rectangle;

static int within(float v, int lo, int hi)
{
    v = v < (float)lo ? (float)lo : v;
    v = v > (float)hi ? (float)hi : v;
    return (int)v;
}

/* 1/2 sum |axis - t forward| */
static float spread(const float axis[3], float t, const float forward[3])
{
    return OST_HALF * ((fabsf(axis[0] - t * forward[0]) + fabsf(axis[1] - t * forward[1])) + fabsf(axis[2] - t * forward[2]));
}

/* False when the voxel cannot be seen. */
static bool rectangle_of(const ost_splat_eye *s, const float o[3], int y0, int y1, rectangle *r)
{
    const ost_eye *e = &s->eye;
    const float x = ost_eye_dot(e->right, o), y = ost_eye_dot(e->up, o), z = ost_eye_dot(e->forward, o);
    const float nearest = z - s->reach[2];
    if (!(nearest > e->near))
        return false;
    const float inverse = 1.0f / z, tx = x * inverse, ty = y * inverse, k = e->focal / nearest;
    const float hx = spread(e->right, tx, e->forward) * k + 0.01f, hy = spread(e->up, ty, e->forward) * k + 0.01f;
    const float px = tx * e->focal + (e->half_w - 0.5f), py = (e->half_h - 0.5f) - ty * e->focal;
    *r = (rectangle){within(ceilf(px - hx), 0, e->width), within(floorf(px + hx), -1, e->width - 1), within(ceilf(py - hy), y0, y1),
                     within(floorf(py + hy), y0 - 1, y1 - 1)};
    return r->x0 <= r->x1 && r->y0 <= r->y1;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static bool covers(const float n[3], const float d[3])
{
    const float m[3] = {fabsf(d[0]), fabsf(d[1]), fabsf(d[2])};
    return fabsf(n[0]) <= OST_HALF_WIDE * (m[1] + m[2]) && fabsf(n[1]) <= OST_HALF_WIDE * (m[2] + m[0]) &&
           fabsf(n[2]) <= OST_HALF_WIDE * (m[0] + m[1]);
}

static void fill(const ost_splat_eye *s, const float o[3], uint32_t index, const rectangle *r, const ost_planes *planes)
{
    const float distance = ost_eye_dot(o, o);
    float n[3][3]; /* o x each of the axes that d is made of */
    for (int i = 0; i < 3; i++)
        cross(o, s->axis[i], n[i]);
    for (int y = r->y0; y <= r->y1; y++) {
        const float v = ((float)y + 0.5f) - s->eye.half_h;
        float row_n[3], row_d[3];
        for (int a = 0; a < 3; a++) {
            row_n[a] = n[0][a] - v * n[2][a];
            row_d[a] = s->axis[0][a] - v * s->axis[2][a];
        }
        for (int x = r->x0; x <= r->x1; x++) {
            const float u = ((float)x + 0.5f) - s->eye.half_w;
            const size_t at = (size_t)y * (size_t)planes->stride + (size_t)x;
            const float here_n[3] = {row_n[0] + u * n[1][0], row_n[1] + u * n[1][1], row_n[2] + u * n[1][2]};
            const float here_d[3] = {row_d[0] + u * s->axis[1][0], row_d[1] + u * s->axis[1][1], row_d[2] + u * s->axis[1][2]};
            if (distance < planes->distance[at] && covers(here_n, here_d)) {
                planes->distance[at] = distance;
                planes->index[at] = index;
            }
        }
    }
}

/* From the eye to the voxel. */
static void place(const float *bases, uint32_t id, float o[3])
{
    const float *base = bases + 4 * (size_t)(id >> OST_LOCAL_BITS);
    o[0] = base[0] + (float)(id & 31);
    o[1] = base[1] + (float)(id >> 5 & 31);
    o[2] = base[2] + (float)(id >> 10 & 31);
}

void ost_splat_scalar(const ost_splat_eye *eye, const ost_visible *visible, uint32_t first, uint32_t count, const ost_planes *planes, int y0,
                      int y1)
{
    for (uint32_t i = first; i < first + count; i++) {
        float o[3];
        rectangle r;
        place(visible->bases, visible->id[i], o);
        if (rectangle_of(eye, o, y0, y1, &r))
            fill(eye, o, i, &r, planes);
    }
}

/* The plane of the box that the ray passes last on its way in: of each axis the one that it meets first, of those the farthest. */
static unsigned enter(const ost_splat_eye *eye, const float o[3], float u, float v, float *t)
{
    unsigned face = 0;
    for (unsigned a = 0; a < 3; a++) {
        float d = (eye->axis[0][a] - v * eye->axis[2][a]) + u * eye->axis[1][a];
        d = d == 0 ? 1e-20f : d;
        const float inverse = 1.0f / d;
        const float in = o[a] * inverse - OST_HALF * fabsf(inverse);
        if (a == 0 || in > *t) {
            *t = in;
            face = 2 * a + (d < 0);
        }
    }
    return face;
}

void ost_resolve_scalar(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y)
{
    const float v = ((float)y + 0.5f) - eye->eye.half_h;
    for (int x = 0; x < planes->stride; x++) {
        const size_t at = (size_t)y * (size_t)planes->stride + (size_t)x;
        const uint32_t index = planes->index[at];
        if (index == OST_NO_VOXEL) {
            planes->face[at] = OST_NO_FACE;
            planes->colour[at] = visible->background;
            continue;
        }
        const float u = ((float)x + 0.5f) - eye->eye.half_w;
        float o[3], t = 0;
        place(visible->bases, visible->id[index], o);
        const unsigned face = enter(eye, o, u, v, &t);
        planes->face[at] = (uint8_t)face;
        planes->depth[at] = t * eye->eye.focal;
        planes->colour[at] = ost_lit(visible->tint[index], visible->light[face]);
    }
}
