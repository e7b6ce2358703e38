/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/triangle_row.h"

#include <stdlib.h>
#include <string.h>

/* Parts of a pixel, and the largest coordinate: 2^20 pixels. A product of two differences is below 2^60. */
enum { PARTS = 256, COORDINATE_MAX = 1 << 28, CORNERS_MAX = 4 };

/* A corner in the camera's frame: right, up, forward. The normal is in the frame of the mesh. */
typedef struct corner {
    float at[3], normal[3];
} corner;

static corner corner_of(const ost_eye *eye, const ost_smooth_triangle *t, int c)
{
    float o[3];
    corner out;
    for (int a = 0; a < 3; a++)
        o[a] = t->corner[c].at[a] - eye->at[a];
    out.at[0] = ost_eye_dot(o, eye->right);
    out.at[1] = ost_eye_dot(o, eye->up);
    out.at[2] = ost_eye_dot(o, eye->forward);
    memcpy(out.normal, t->corner[c].normal, sizeof out.normal);
    return out;
}

/* Returns the point at which the line from a to b passes the near plane. */
static corner between(const corner *a, const corner *b, float near)
{
    const float share = (near - a->at[2]) / (b->at[2] - a->at[2]);
    corner out;
    for (int i = 0; i < 3; i++) {
        out.at[i] = a->at[i] + share * (b->at[i] - a->at[i]);
        out.normal[i] = a->normal[i] + share * (b->normal[i] - a->normal[i]);
    }
    out.at[2] = near;
    return out;
}

/* Keeps the part of a triangle beyond the near plane. Returns its number of corners: 0, 3 or 4. */
static int clip(const corner in[3], float near, corner out[CORNERS_MAX])
{
    int n = 0;
    for (int i = 0; i < 3; i++) {
        const corner *a = &in[i], *b = &in[(i + 1) % 3];
        const bool a_beyond = a->at[2] >= near, b_beyond = b->at[2] >= near;
        if (a_beyond)
            out[n++] = *a;
        if (a_beyond != b_beyond)
            out[n++] = between(a, b, near);
    }
    return n;
}

/* Rounds a position in pixels to 256ths. */
static int32_t parts_of(float pixels)
{
    const float v = pixels * PARTS;
    return v > (float)-COORDINATE_MAX && v < (float)COORDINATE_MAX ? (int32_t)floorf(v + 0.5f)
           : v > 0                                                 ? COORDINATE_MAX
                                                                   : -COORDINATE_MAX;
}

static int32_t least(const int32_t v[3])
{
    const int32_t a = v[0] < v[1] ? v[0] : v[1];
    return a < v[2] ? a : v[2];
}

static int32_t greatest(const int32_t v[3])
{
    const int32_t a = v[0] > v[1] ? v[0] : v[1];
    return a > v[2] ? a : v[2];
}

/* Rounds a quotient up. `by` is positive. */
static int64_t divide_up(int64_t a, int64_t by)
{
    return a / by + (a % by > 0);
}

/* Returns the half-open range of pixels, within 0 to `size`, whose middles lie from lo to hi (256ths). */
static void middles(int32_t lo, int32_t hi, int size, int *from, int *to)
{
    const int64_t first = divide_up((int64_t)lo - PARTS / 2, PARTS),
                  end = divide_up((int64_t)hi - PARTS / 2 + 1, PARTS);
    *from = first > 0 ? first < size ? (int)first : size : 0;
    *to = end < size ? end > 0 ? (int)end : 0 : size;
}

/* Adds a triangle that lies beyond the near plane. Omits a triangle that covers no pixel, and one whose back is seen
   although the mesh is closed. */
static void add(ost_triangles *t, const ost_eye *eye, const corner *const c[3], bool closed)
{
    ost_flat_triangle *f = &t->triangle[t->count];
    for (int i = 0; i < 3; i++) {
        const float inverse = 1.0f / c[i]->at[2];
        f->inverse[i] = inverse;
        f->x[i] = parts_of(c[i]->at[0] * inverse * eye->focal + eye->half_w);
        f->y[i] = parts_of(eye->half_h - c[i]->at[1] * inverse * eye->focal);
    }
    const int64_t area = (int64_t)(f->x[1] - f->x[0]) * (f->y[2] - f->y[0]) -
                         (int64_t)(f->x[2] - f->x[0]) * (f->y[1] - f->y[0]);
    /* seen from outside, the corners are counter-clockwise, which is a negative area because y points down */
    const bool front = area < 0;
    middles(least(f->x), greatest(f->x), eye->width, &f->pixels.x0, &f->pixels.x1);
    middles(least(f->y), greatest(f->y), eye->height, &f->pixels.y0, &f->pixels.y1);
    if (area == 0 || (closed && !front) || f->pixels.x0 >= f->pixels.x1 || f->pixels.y0 >= f->pixels.y1)
        return;
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            f->normal[i][a] = (front ? c[i]->normal[a] : -c[i]->normal[a]) * f->inverse[i];
    if (front) { /* exchanges two corners, so that the area is positive */
        const ost_flat_triangle was = *f;
        f->x[1] = was.x[2], f->x[2] = was.x[1];
        f->y[1] = was.y[2], f->y[2] = was.y[1];
        f->inverse[1] = was.inverse[2], f->inverse[2] = was.inverse[1];
        memcpy(f->normal[1], was.normal[2], sizeof f->normal[1]);
        memcpy(f->normal[2], was.normal[1], sizeof f->normal[2]);
    }
    t->y0 = f->pixels.y0 < t->y0 ? f->pixels.y0 : t->y0;
    t->y1 = f->pixels.y1 > t->y1 ? f->pixels.y1 : t->y1;
    t->count++;
}

ost_status ost_triangles_project(ost_triangles *t, const ost_smooth_mesh *mesh, const ost_eye *eye, ost_paint paint,
                                 float scale, ost_error *err)
{
    const size_t most = 2 * mesh->count; /* clipping divides a triangle into at most two */
    if (t->capacity < most) {
        ost_flat_triangle *grown = realloc(t->triangle, most * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu triangles of a picture", most);
        t->triangle = grown;
        t->capacity = most;
    }
    t->count = 0;
    t->y0 = eye->height;
    t->y1 = 0;
    t->lamps = ost_lamps_make(eye);
    t->colour = paint.red | (uint32_t)paint.green << 8 | (uint32_t)paint.blue << 16;
    t->gloss = paint.gloss;
    t->scale = scale;
    for (size_t i = 0; i < mesh->count; i++) {
        corner in[3], out[CORNERS_MAX];
        for (int c = 0; c < 3; c++)
            in[c] = corner_of(eye, &mesh->triangle[i], c);
        const int n = clip(in, eye->near, out);
        for (int c = 2; c < n; c++)
            add(t, eye, (const corner *const[]){&out[0], &out[c - 1], &out[c]}, mesh->closed);
    }
    return OST_OK;
}

/* The side of a triangle that is opposite to a corner. Its value is 0 on the side and positive inside. */
typedef struct side {
    int64_t value; /* at the middle of the first pixel of a row */
    int64_t step;  /* from pixel to pixel */
} side;

static side side_of(const ost_flat_triangle *f, int opposite, int y)
{
    const int a = (opposite + 1) % 3, b = (opposite + 2) % 3;
    const int64_t dx = f->x[b] - f->x[a], dy = f->y[b] - f->y[a];
    return (side){dx * ((int64_t)y * PARTS + PARTS / 2 - f->y[a]) - dy * (PARTS / 2 - f->x[a]), -dy * PARTS};
}

/* Narrows a half-open range of pixels to those on the inner side. */
static void narrow(const side *s, int *from, int *to)
{
    if (s->step == 0) {
        *to = s->value < 0 ? *from : *to;
    } else if (s->step > 0) {
        const int64_t first = divide_up(-s->value, s->step);
        *from = first > *from ? first < *to ? (int)first : *to : *from;
    } else {
        const int64_t end = s->value < 0 ? 0 : s->value / -s->step + 1;
        *to = end < *to ? end > *from ? (int)end : *from : *to;
    }
}

/* Finds the pixels of row y whose middles are in the triangle. Returns false if there are none. */
static bool span_of(const ost_flat_triangle *f, int y, ost_triangle_span *out)
{
    const side s[3] = {side_of(f, 0, y), side_of(f, 1, y), side_of(f, 2, y)};
    int from = f->pixels.x0, to = f->pixels.x1;
    for (int i = 0; i < 3; i++)
        narrow(&s[i], &from, &to);
    /* The three values have the same sum at every pixel: twice the area. */
    const float whole = 1.0f / (float)(s[0].value + s[1].value + s[2].value);
    *out = (ost_triangle_span){.from = from,
                               .to = to,
                               .b = (float)(s[1].value + from * s[1].step) * whole,
                               .b_step = (float)s[1].step * whole,
                               .c = (float)(s[2].value + from * s[2].step) * whole,
                               .c_step = (float)s[2].step * whole};
    return from < to;
}

bool ost_triangle_row_scalar(const ost_triangles *t, const ost_flat_triangle *f, const ost_triangle_span *span, int y,
                             const ost_planes *planes)
{
    return ost_row_draw(t, f, span, y, planes);
}

ost_triangle_row *ost_triangle_row_for(ost_isa isa)
{
#if HAVE_AVX2_BUILD
    if (isa == OST_ISA_AVX2 || isa == OST_ISA_AVX512)
        return ost_triangle_row_avx2;
#endif
    (void)isa;
    return ost_triangle_row_scalar;
}

void ost_triangles_draw(const ost_triangles *t, ost_triangle_row *row, const ost_planes *planes, int y0, int y1,
                        const ost_cells *over)
{
    if (t->y0 >= y1 || t->y1 <= y0)
        return;
    for (size_t i = 0; i < t->count; i++) {
        const ost_flat_triangle *f = &t->triangle[i];
        const int top = f->pixels.y0 > y0 ? f->pixels.y0 : y0, end = f->pixels.y1 < y1 ? f->pixels.y1 : y1;
        for (int y = top; y < end; y++) {
            ost_triangle_span span;
            if (span_of(f, y, &span) && row(t, f, &span, y, planes))
                ost_cells_add(over, span.from, span.to, y, y + 1);
        }
    }
}

void ost_triangles_free(ost_triangles *t)
{
    free(t->triangle);
    *t = (ost_triangles){0};
}
