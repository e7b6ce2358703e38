/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a voxel whose centre is o, relative to the eye:
 *
 *   in the camera's frame    x = o . right, y = o . up, z = o . forward
 *   tx = x / z               slope of the centre. The slope of a corner (x', z') differs from tx by at most
 *                            s / (z - reach), where s = 1/2 sum |right - tx forward|, because
 *                            x' - t z' = (x - t z) + (half widths) <= 0 is true for all corners
 *                            if t - tx >= s / (smallest z')
 *   rectangle                bounded by these slopes, and extended by a hundredth of a pixel
 *   covered                  |o x d|_a <= h (|d_b| + |d_c|) for the three axes a, where h is half
 *                            a side: the line along d then meets the cube around o
 *
 * For a line that meets the cube, d_a has the sign of o_a on each axis with |o_a| > h. With these signs g, the test
 * consists of six inequalities that are linear in the pixel's position, one for each edge of the outline:
 *
 *   h (g_b d_b + g_c d_c) -+ (o x d)_a >= 0        d = focal forward + u right + v up
 *
 * On an axis with |o_a| <= h, the code tests both signs, and a pixel is covered if one of the two tests passes. A wrong
 * sign can only make a test stricter, because g d <= |d|.
 *
 * If only one face of a voxel is exposed and turned to the eye, it is sufficient to draw that face: a ray that enters
 * through another face turned to the eye comes from the neighbour at that face, and this neighbour or a voxel in front
 * of it is nearer. If the eye is too close for this to hold, frame.c draws the entire voxel. If only face a is drawn,
 * the rectangle is that of the face, and two of the face's edges lie inside the voxel's outline. Each of these two is
 * obtained from an outline edge whose inequality contains g_a d_a and g_j d_j, by reversing the sign of h g_j d_j.
 *
 * A voxel is drawn only if all its corners are beyond the near plane, so every line in the test can be treated as a
 * ray.
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
        for (int i = 0; i < 3; i++)
            s.wide[i][a] = OST_HALF_WIDE * s.axis[i][a];
    }
    return s;
}

uint32_t ost_facing_scalar(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK],
                           ost_chosen *out)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        const uint32_t p = block->points[i];
        const uint32_t seen = p >> OST_FACES_SHIFT &
                              (uint32_t)(turned[0][p & 31] | turned[1][p >> 5 & 31] | turned[2][p >> 10 & 31]);
        out->id[n] = slot << OST_LOCAL_BITS | (p & ((1u << OST_LOCAL_BITS) - 1));
        out->shade[n] = block->shades[i];
        out->only[n] = (uint8_t)(seen & (seen - 1) ? OST_SEVERAL : seen > 15 ? 2 : seen > 3);
        n += seen != 0;
    }
    return n;
}

typedef struct rectangle {
    int x0, x1, y0, y1; /* columns x0 to x1 and rows y0 to y1, inclusive */
} rectangle;

static int within(float v, int lo, int hi)
{
    v = v < (float)lo ? (float)lo : v;
    v = v > (float)hi ? (float)hi : v;
    return (int)v;
}

/* Returns half of the sum of |axis[a] - t forward[a]| over the axes a. The term of the axis `only` is omitted. */
static float spread(const float axis[3], float t, const float forward[3], unsigned only)
{
    float part[3];
    for (unsigned a = 0; a < 3; a++)
        part[a] = a == only ? 0 : fabsf(axis[a] - t * forward[a]);
    return OST_HALF * ((part[0] + part[1]) + part[2]);
}

/*
 * Computes the pixels that a voxel may cover or, if only one face is drawn, that this face may cover. Returns false if
 * there are none.
 */
static bool rectangle_of(const ost_splat_eye *s, const float o[3], unsigned only, rectangle *r)
{
    static const float origin[3];
    const ost_eye *e = &s->eye;
    float middle[3];
    if (!(ost_eye_dot(e->forward, o) - s->reach[2] > e->near))
        return false;
    for (unsigned a = 0; a < 3; a++)
        middle[a] = a != only ? o[a] : o[a] < 0 ? o[a] + OST_HALF : o[a] - OST_HALF;
    const float x = ost_eye_dot(e->right, middle), y = ost_eye_dot(e->up, middle), z = ost_eye_dot(e->forward, middle);
    const float nearest = z - spread(e->forward, 0, origin, only);
    const float inverse = 1.0f / z, tx = x * inverse, ty = y * inverse, k = e->focal / nearest;
    const float hx = spread(e->right, tx, e->forward, only) * k + 0.01f,
                hy = spread(e->up, ty, e->forward, only) * k + 0.01f;
    const float px = tx * e->focal + (e->half_w - 0.5f), py = (e->half_h - 0.5f) - ty * e->focal;
    *r = (rectangle){within(ceilf(px - hx), 0, e->width), within(floorf(px + hx), -1, e->width - 1),
                     within(ceilf(py - hy), 0, e->height), within(floorf(py + hy), -1, e->height - 1)};
    return r->x0 <= r->x1 && r->y0 <= r->y1;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* An edge of the outline: a + u * b + v * c is positive inside the outline. */
typedef struct edge {
    float a, b, c;
} edge;

/*
 * Computes the edges of a voxel's outline. Bit a of `negative` is set if rays run in the negative direction of axis a.
 * If only one face is drawn, `only` is its axis; otherwise, `only` is OST_SEVERAL.
 */
static void edges_of(const ost_splat_eye *s, const float o[3], unsigned negative, unsigned only, edge out[6])
{
    /*
     * n[i] and m[i] are computed from the vector v, which is focal * forward, right or up for i = 0, 1 or 2. n[i] is
     * the cross product o x v. m[i] is v * OST_HALF_WIDE, with the sign reversed on the axes in `negative`.
     */
    float n[3][3], m[3][3];
    for (int i = 0; i < 3; i++) {
        cross(o, s->axis[i], n[i]);
        for (int a = 0; a < 3; a++)
            m[i][a] = negative >> a & 1 ? -s->wide[i][a] : s->wide[i][a];
    }
    for (unsigned a = 0; a < 3; a++) {
        const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
        const bool same = (negative >> b & 1) == (negative >> c & 1);
        const bool turn_first = only == (same ? c : b), turn_second = only == (same ? b : c);
        float first[3], second[3];
        for (int i = 0; i < 3; i++) {
            const float both = m[i][b] + m[i][c], turned = only == b ? m[i][b] - m[i][c] : m[i][c] - m[i][b];
            first[i] = (turn_first ? turned : both) - n[i][a];
            second[i] = (turn_second ? turned : both) + n[i][a];
        }
        out[2 * a] = (edge){first[0], first[1], first[2]};
        out[2 * a + 1] = (edge){second[0], second[1], second[2]};
    }
}

static void fill(const ost_splat_eye *s, const edge e[6], uint64_t key, const rectangle *r, const ost_planes *planes)
{
    for (int y = r->y0; y <= r->y1; y++) {
        const float v = s->eye.half_h - ((float)y + 0.5f);
        float row[6];
        for (int i = 0; i < 6; i++)
            row[i] = e[i].a + v * e[i].c;
        for (int x = r->x0; x <= r->x1; x++) {
            const float u = ((float)x + 0.5f) - s->eye.half_w;
            uint64_t *was = &ost_key_row(planes, y)[x];
            bool within = key < *was;
            for (int i = 0; i < 6 && within; i++)
                within = !signbit(row[i] + u * e[i].b);
            if (within)
                *was = key;
        }
    }
}

/* Computes the vector from the eye to the voxel's centre. */
static void place(const float *bases, uint32_t id, float o[3])
{
    const float *base = bases + 4 * (size_t)(id >> OST_LOCAL_BITS);
    o[0] = base[0] + (float)(id & 31);
    o[1] = base[1] + (float)(id >> 5 & 31);
    o[2] = base[2] + (float)(id >> 10 & 31);
}

static void splat(const ost_splat_eye *eye, const float o[3], unsigned only, uint64_t key, const rectangle *r,
                  const ost_planes *planes)
{
    unsigned negative = 0, inside = 0;
    for (int a = 0; a < 3; a++) {
        negative |= (unsigned)(o[a] < 0) << a;
        inside |= (unsigned)(fabsf(o[a]) <= OST_FACE_HALF) << a;
    }
    for (unsigned turned = 0; turned < 8; turned++) {
        edge e[6];
        if (turned & ~inside)
            continue;
        edges_of(eye, o, negative ^ turned, only, e);
        fill(eye, e, key, r, planes);
    }
}

static void widen(ost_extent *e, const rectangle *r)
{
    e->x0 = r->x0 < e->x0 ? r->x0 : e->x0;
    e->x1 = r->x1 + 1 > e->x1 ? r->x1 + 1 : e->x1;
    e->y0 = r->y0 < e->y0 ? r->y0 : e->y0;
    e->y1 = r->y1 + 1 > e->y1 ? r->y1 + 1 : e->y1;
}

/* Draws a group of entries of a list, whose indices are from <= i < to. Returns the extent word of the group. */
static uint64_t splat_some(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t from,
                           uint32_t to, const ost_planes *planes, const ost_extent *part)
{
    ost_extent all = {eye->eye.width, 0, eye->eye.height, 0};
    for (uint32_t i = from; i < to; i++) {
        const uint32_t at = visible->begin[slot] + i;
        float o[3];
        rectangle r;
        place(visible->bases, (uint32_t)visible->seen[at], o);
        if (!rectangle_of(eye, o, visible->only[at], &r))
            continue;
        widen(&all, &r);
        if (r.x0 >= part->x1 || r.x1 < part->x0)
            continue;
        r.y0 = r.y0 > part->y0 ? r.y0 : part->y0;
        r.y1 = r.y1 < part->y1 ? r.y1 : part->y1 - 1;
        splat(eye, o, visible->only[at], ost_key(ost_eye_dot(o, o), ost_number(slot, i)), &r, planes);
    }
    return all.y0 < all.y1 ? ost_extent_word(all.x0, all.x1, all.y0, all.y1) : OST_EXTENT_NONE;
}

void ost_splat_scalar(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,
                      const ost_planes *planes, const ost_extent *part)
{
    for (uint32_t i = 0; i < count; i += OST_LANES) {
        _Atomic uint64_t *extent = &visible->extent[(visible->begin[slot] + i) / OST_LANES];
        const uint64_t known = atomic_load_explicit(extent, memory_order_relaxed);
        if (ost_extent_misses(known, part))
            continue;
        const uint64_t found = splat_some(eye, visible, slot, i, count - i < OST_LANES ? count : i + OST_LANES, planes,
                                          part);
        if (known == OST_EXTENT_UNKNOWN)
            atomic_store_explicit(extent, found, memory_order_relaxed);
    }
}

/*
 * Returns the face through which the ray enters the cube: of the three faces that are turned to the eye, the one whose
 * plane the ray crosses last. The ray crosses the plane of axis a at the distance (|o_a| - 1/2) / |d_a|, in units of
 * the length of d. Products are compared instead of these quotients, so that only one division is needed.
 */
static unsigned enter(const ost_splat_eye *eye, const float o[3], float u, float v, float *depth)
{
    float near[3], d[3];
    for (int a = 0; a < 3; a++) {
        near[a] = fabsf(o[a]) - OST_HALF;
        d[a] = fabsf((eye->axis[0][a] + v * eye->axis[2][a]) + u * eye->axis[1][a]);
    }
    unsigned best = near[1] * d[0] > near[0] * d[1] ? 1 : 0;
    if (near[2] * d[best] > near[best] * d[2])
        best = 2;
    const float least = 1e-20f;
    *depth = (near[best] / (d[best] > least ? d[best] : least)) * eye->eye.focal;
    return 2 * best + (o[best] < 0);
}

void ost_resolve_scalar(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0,
                        int x1)
{
    const float v = eye->eye.half_h - ((float)y + 0.5f);
    for (int x = x0; x < x1; x++) {
        const size_t at = ost_row(planes, y) + (size_t)x;
        const uint64_t key = ost_key_row(planes, y)[x];
        if (key >> 32 == OST_NO_DISTANCE) {
            planes->face[at] = OST_NO_FACE;
            planes->colour[at] = visible->background;
            continue;
        }
        const uint32_t index = ost_visible_index(visible, (uint32_t)key);
        const float u = ((float)x + 0.5f) - eye->eye.half_w;
        float o[3];
        place(visible->bases, (uint32_t)visible->seen[index], o);
        const unsigned face = enter(eye, o, u, v, &planes->depth[at]);
        planes->face[at] = (uint8_t)face;
        planes->colour[at] = ost_lit((uint32_t)(visible->seen[index] >> 32), visible->light[face]);
    }
}

uint64_t ost_farthest_scalar(const ost_planes *planes, int x, int y, int rows)
{
    uint64_t most = 0;
    for (int j = y; j < y + rows; j++)
        for (int i = x; i < x + OST_TILE; i++) {
            const uint64_t key = ost_key_row(planes, j)[i];
            most = key > most ? key : most;
        }
    return most;
}

void ost_merge_scalar(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken)
{
    for (int x = x0; x < x1; x++) {
        const size_t i = ost_row(from, y) + (size_t)x, at = ost_row(to, y) + (size_t)x;
        const float depth = from->depth[i] * scale;
        if (from->face[i] == OST_NO_FACE || (to->face[at] != OST_NO_FACE && !(depth < to->depth[at])))
            continue;
        to->depth[at] = depth;
        to->face[at] = from->face[i];
        to->colour[at] = from->colour[i];
        ost_taken(taken, x);
    }
}
