/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/triangle_row.h"

#include <stdlib.h>
#include <string.h>

/* Coordinates are in PARTS of a pixel and limited to 2^20 pixels, so a product of two differences is below 2^60. */
enum { PARTS = OST_PIXEL_PARTS, COORDINATE_MAX = 1 << 28, CORNERS_MAX = 4 };

/* A corner of a triangle, with its normal in the frame of the mesh. */
typedef struct corner {
    ost_flat_corner flat;
    float normal[3];
} corner;

/* Rounds a position in pixels to 256ths. */
static int32_t parts_of(float pixels)
{
    const float v = pixels * PARTS;
    return v > (float)-COORDINATE_MAX && v < (float)COORDINATE_MAX ? (int32_t)floorf(v + 0.5f)
           : v > 0                                                 ? COORDINATE_MAX
                                                                   : -COORDINATE_MAX;
}

/* Projects a corner that lies beyond the near plane. */
static void flatten(const ost_eye *eye, ost_flat_corner *c)
{
    c->inverse = 1.0f / c->at[2];
    c->x = parts_of(c->at[0] * c->inverse * eye->focal + eye->half_w);
    c->y = parts_of(eye->half_h - c->at[1] * c->inverse * eye->focal);
}

static ost_flat_corner corner_of(const ost_eye *eye, const float at[3])
{
    float o[3];
    ost_flat_corner out;
    for (int a = 0; a < 3; a++)
        o[a] = at[a] - eye->at[a];
    out.at[0] = ost_eye_dot(o, eye->right);
    out.at[1] = ost_eye_dot(o, eye->up);
    out.at[2] = ost_eye_dot(o, eye->forward);
    if (out.at[2] >= eye->near)
        flatten(eye, &out);
    return out;
}

/* Returns the intersection of the line from a to b with the near plane. */
static corner between(const corner *a, const corner *b, const ost_eye *eye)
{
    const float share = (eye->near - a->flat.at[2]) / (b->flat.at[2] - a->flat.at[2]);
    corner out;
    for (int i = 0; i < 3; i++) {
        out.flat.at[i] = a->flat.at[i] + share * (b->flat.at[i] - a->flat.at[i]);
        out.normal[i] = a->normal[i] + share * (b->normal[i] - a->normal[i]);
    }
    out.flat.at[2] = eye->near;
    flatten(eye, &out.flat);
    return out;
}

/* Clips a triangle to the space beyond the near plane. Returns the number of corners of the remaining polygon: 0, 3 or
 * 4. */
static int clip(const corner in[3], const ost_eye *eye, corner out[CORNERS_MAX])
{
    int n = 0;
    for (int i = 0; i < 3; i++) {
        const corner *a = &in[i], *b = &in[(i + 1) % 3];
        const bool a_beyond = a->flat.at[2] >= eye->near, b_beyond = b->flat.at[2] >= eye->near;
        if (a_beyond)
            out[n++] = *a;
        if (a_beyond != b_beyond)
            out[n++] = between(a, b, eye);
    }
    return n;
}

/* Finds the half-open range of the pixels in [0, size) whose centres lie between the smallest and the largest of three
   coordinates. Coordinates are in 256ths of a pixel. */
static void middles(int32_t a, int32_t b, int32_t c, int size, int *from, int *to)
{
    const int32_t least = a < b ? a < c ? a : c : b < c ? b : c, most = a > b ? a > c ? a : c : b > c ? b : c;
    /*
     * `first` is the first pixel whose centre is not below the smallest coordinate. `end` is the first pixel whose
     * centre is above the largest coordinate. The shifts round down, even for negative numbers. Coordinates are at most
     * 2^28.
     */
    const int first = (least + PARTS / 2 - 1) >> 8, end = (most + PARTS / 2) >> 8;
    *from = first > 0 ? first < size ? first : size : 0;
    *to = end < size ? end > 0 ? end : 0 : size;
}

/* Adds a triangle that lies beyond the near plane. A triangle is omitted if it covers no pixel, or if the mesh is
   closed and the triangle faces away from the eye. */
static void add(ost_triangles *t, const ost_eye *eye, const ost_flat_corner *const c[3], const float *const normal[3],
                bool closed)
{
    ost_flat_triangle *f = &t->triangle[t->count];
    const int64_t area = (int64_t)(c[1]->x - c[0]->x) * (c[2]->y - c[0]->y) -
                         (int64_t)(c[2]->x - c[0]->x) * (c[1]->y - c[0]->y);
    /*
     * Seen from outside, the corners are counter-clockwise, so the area is negative in the picture, where y points
     * down.
     */
    const bool front = area < 0;
    if (area == 0 || (closed && !front))
        return;
    middles(c[0]->x, c[1]->x, c[2]->x, eye->width, &f->pixels.x0, &f->pixels.x1);
    middles(c[0]->y, c[1]->y, c[2]->y, eye->height, &f->pixels.y0, &f->pixels.y1);
    if (f->pixels.x0 >= f->pixels.x1 || f->pixels.y0 >= f->pixels.y1)
        return;
    for (int i = 0; i < 3; i++) {
        const int from = front ? (3 - i) % 3 : i; /* exchanges two corners so that the area is positive */
        f->x[i] = c[from]->x;
        f->y[i] = c[from]->y;
        f->inverse[i] = c[from]->inverse;
        for (int a = 0; a < 3; a++)
            f->normal[i][a] = (front ? normal[from][a] : -normal[from][a]) * f->inverse[i];
    }
    f->whole = 1.0f / (float)(front ? -area : area);
    t->y0 = f->pixels.y0 < t->y0 ? f->pixels.y0 : t->y0;
    t->y1 = f->pixels.y1 > t->y1 ? f->pixels.y1 : t->y1;
    t->count++;
}

/* Adds the part of a triangle that lies beyond the near plane. */
static void add_clipped(ost_triangles *t, const ost_eye *eye, const ost_flat_corner *const c[3],
                        const float *const normal[3], bool closed)
{
    corner in[3], out[CORNERS_MAX];
    for (int i = 0; i < 3; i++) {
        in[i].flat = *c[i];
        memcpy(in[i].normal, normal[i], sizeof in[i].normal);
    }
    const int n = clip(in, eye, out);
    for (int i = 2; i < n; i++)
        add(t, eye, (const ost_flat_corner *const[]){&out[0].flat, &out[i - 1].flat, &out[i].flat},
            (const float *const[]){out[0].normal, out[i - 1].normal, out[i].normal}, closed);
}

static ost_status reserve(ost_triangles *t, const ost_smooth_mesh *mesh, ost_error *err)
{
    const size_t most = 2 * mesh->count; /* clipping may divide a triangle into two */
    if (t->capacity < most) {
        ost_flat_triangle *grown = realloc(t->triangle, most * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu triangles of a picture", most);
        t->triangle = grown;
        t->capacity = most;
    }
    if (t->corner_capacity < mesh->positions) {
        ost_flat_corner *grown = realloc(t->corner, mesh->positions * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu corners of a picture", mesh->positions);
        t->corner = grown;
        t->corner_capacity = mesh->positions;
    }
    return OST_OK;
}

ost_status ost_triangles_project(ost_triangles *t, const ost_smooth_mesh *mesh, const ost_eye *eye, ost_paint paint,
                                 float scale, ost_error *err)
{
    ost_status status = reserve(t, mesh, err);
    if (status != OST_OK)
        return status;
    t->count = 0;
    t->y0 = eye->height;
    t->y1 = 0;
    t->lamps = ost_lamps_make(eye);
    t->colour = paint.red | (uint32_t)paint.green << 8 | (uint32_t)paint.blue << 16;
    t->gloss = paint.gloss;
    t->scale = scale;
    for (size_t i = 0; i < mesh->positions; i++)
        t->corner[i] = corner_of(eye, mesh->position[i]);
    for (size_t i = 0; i < mesh->count; i++) {
        const uint32_t *p = mesh->place[i];
        const ost_smooth_corner *n = mesh->triangle[i].corner;
        const ost_flat_corner *const c[3] = {&t->corner[p[0]], &t->corner[p[1]], &t->corner[p[2]]};
        const float *const normal[3] = {n[0].normal, n[1].normal, n[2].normal};
        if (c[0]->at[2] >= eye->near && c[1]->at[2] >= eye->near && c[2]->at[2] >= eye->near)
            add(t, eye, c, normal, mesh->closed);
        else
            add_clipped(t, eye, c, normal, mesh->closed);
    }
    return OST_OK;
}

void ost_triangle_rows_scalar(const ost_triangles *t, const ost_flat_triangle *f, const ost_planes *planes, int y0,
                              int y1, const ost_cells *over)
{
    ost_row_triangle(t, f, planes, y0, y1, over);
}

ost_triangle_rows *ost_triangle_rows_for(ost_isa isa)
{
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        return ost_triangle_rows_avx2;
#endif
    (void)isa;
    return ost_triangle_rows_scalar;
}

void ost_triangles_draw(const ost_triangles *t, ost_triangle_rows *rows, const ost_planes *planes, int y0, int y1,
                        const ost_cells *over)
{
    if (t->y0 >= y1 || t->y1 <= y0)
        return;
    for (size_t i = 0; i < t->count; i++) {
        const ost_extent *e = &t->triangle[i].pixels;
        if (e->y0 < y1 && e->y1 > y0)
            rows(t, &t->triangle[i], planes, e->y0 > y0 ? e->y0 : y0, e->y1 < y1 ? e->y1 : y1, over);
    }
}

void ost_triangles_free(ost_triangles *t)
{
    free(t->triangle);
    free(t->corner);
    *t = (ost_triangles){0};
}
