/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a line step by step along its major axis, x or y, in the picture. The reciprocal of depth is linear in the
 * picture, which yields the depth at each step. Each step blends the colour into the pixels across the line, in
 * proportion to their coverage.
 */
#include "render/overlay.h"

#include <math.h>

#include "core/conditions.h"
#include "core/rotation.h"
#include "render/points/extract.h"

const char *const ost_overlay_names[OST_OVERLAY_COUNT] = {"chunks",      "boxes",       "hits",
                                                          "tool-voxels", "bone-voxels", "axis",
                                                          "landmarks"};

enum {
    RED = 0x4a4ae8,
    GREY = 0x8a8078,
    AMBER = 0x35b0f5,
    WHITE = 0xf0f0f0,
    GREEN = 0x66d860,
    CYAN = 0xe8c84a,
    FULL = 256
};
/* a line that is at most this many voxels behind a surface is drawn as if it were in front of the surface */
static const float BEHIND = 0.75f;

typedef struct point3 {
    float v[3];
} point3;

/* ------------------------------------------------------------------- lines */

static uint32_t mixed(uint32_t under, uint32_t over, uint32_t share)
{
    const uint32_t complement = FULL - share;
    return (((under & 0xff00ff) * complement + (over & 0xff00ff) * share) >> 8 & 0xff00ff) |
           (((under & 0xff00) * complement + (over & 0xff00) * share) >> 8 & 0xff00);
}

static void dot(const ost_frame *f, int x, int y, float depth, uint32_t colour, uint32_t share)
{
    if (x < 0 || y < 0 || x >= f->width || y >= f->height)
        return;
    const ost_planes *p = &f->planes;
    const size_t at = (size_t)y * (size_t)p->stride + (size_t)x;
    if (p->face[at] != OST_NO_FACE && depth > p->depth[at] + BEHIND)
        share /= 5;
    p->colour[at] = mixed(p->colour[at], colour, share);
    ost_cells_dot(&f->over, x, y);
}

/*
 * Clips the interval [*from, *to], which lies within [0, 1], to the values t with lo <= v0 + t dv <= hi. Returns false
 * if there are none.
 */
static bool narrow(float v0, float dv, float lo, float hi, float *from, float *to)
{
    if (dv == 0)
        return v0 >= lo && v0 <= hi;
    const float a = (lo - v0) / dv, b = (hi - v0) / dv, first = a < b ? a : b, last = a < b ? b : a;
    *from = first > *from ? first : *from;
    *to = last < *to ? last : *to;
    return *from <= *to;
}

/*
 * Projects both ends of a line: computes x, y and the reciprocal of the depth. Returns false if both ends are nearer
 * than the near plane.
 */
static bool project(const ost_eye *e, const float from[3], const float to[3], float out[2][3])
{
    float end[2][3];
    for (int i = 0; i < 2; i++) {
        float o[3];
        for (int a = 0; a < 3; a++)
            o[a] = (i ? to : from)[a] - e->at[a];
        end[i][0] = ost_eye_dot(e->right, o);
        end[i][1] = ost_eye_dot(e->up, o);
        end[i][2] = ost_eye_dot(e->forward, o);
    }
    if (!(end[0][2] > e->near) && !(end[1][2] > e->near))
        return false;
    for (int i = 0; i < 2; i++)
        if (!(end[i][2] > e->near)) {
            const float t = (e->near - end[i][2]) / (end[1 - i][2] - end[i][2]);
            for (int a = 0; a < 2; a++)
                end[i][a] += t * (end[1 - i][a] - end[i][a]);
            end[i][2] = e->near;
        }
    for (int i = 0; i < 2; i++) {
        out[i][2] = 1.0f / end[i][2];
        out[i][0] = e->half_w + end[i][0] * out[i][2] * e->focal;
        out[i][1] = e->half_h - end[i][1] * out[i][2] * e->focal;
    }
    return true;
}

void ost_overlay_line(const ost_frame *f, const ost_eye *eye, const float from[3], const float to[3], uint32_t colour,
                      unsigned strength, int width)
{
    float p[2][3], first = 0, last = 1;
    if (!project(eye, from, to, p))
        return;
    const float d[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    if (!narrow(p[0][0], d[0], -1, (float)f->width + 1, &first, &last) ||
        !narrow(p[0][1], d[1], -1, (float)f->height + 1, &first, &last))
        return;
    const bool flat = fabsf(d[0]) >= fabsf(d[1]);
    const float length = flat ? fabsf(d[0]) : fabsf(d[1]);
    const int a = flat ? 0 : 1, b = 1 - a;
    const float begin = p[0][a] + first * d[a], end = p[0][a] + last * d[a];
    const int lo = (int)floorf(begin < end ? begin : end), hi = (int)ceilf(begin < end ? end : begin);
    for (int i = lo; i < hi; i++) {
        float t = length > 0 ? ((float)i + 0.5f - p[0][a]) / d[a] : 0;
        t = t < first ? first : t > last ? last : t;
        const float side = p[0][b] + t * d[b] - 0.5f * (float)width, depth = 1.0f / (p[0][2] + t * d[2]);
        const int j = (int)floorf(side);
        const uint32_t share = (uint32_t)((side - (float)j) * (float)strength);
        for (int k = 0; k <= width; k++)
            dot(f, flat ? i : j + k, flat ? j + k : i, depth, colour,
                k == 0      ? strength - share
                : k < width ? strength
                            : share);
    }
}

/* Returns the width of a thin line: one pixel per 720 rows of the picture. */
static int thin(const ost_frame *f)
{
    return f->height < 1080 ? 1 : (f->height + 360) / 720;
}

/*
 * Draws the edges of a box. Bit a of a corner's index is 1 if the corner is at the upper end of the box along its axis
 * a.
 */
static void box(const ost_frame *f, const ost_eye *e, const point3 corner[8], uint32_t colour, unsigned strength,
                int width)
{
    for (int i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++)
            if (!(i >> a & 1))
                ost_overlay_line(f, e, corner[i].v, corner[i | 1 << a].v, colour, strength, width);
}

static void upright(const ost_frame *f, const ost_eye *e, const float lo[3], const float hi[3], uint32_t colour,
                    unsigned strength, int width)
{
    point3 corner[8];
    for (int i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++)
            corner[i].v[a] = i >> a & 1 ? hi[a] : lo[a];
    box(f, e, corner, colour, strength, width);
}

/* ------------------------------------------------------------------ chunks */

static void chunk_box(const ost_overlay_scene *s, const int32_t at[3], float in, float lo[3], float hi[3])
{
    for (int a = 0; a < 3; a++) {
        lo[a] = (float)(at[a] * s->chunk) - 0.5f + in;
        hi[a] = (float)((at[a] + 1) * s->chunk) - 0.5f - in;
    }
}

/* Returns true if the chunk has an active voxel. */
static bool is_active(const ost_overlay_scene *s, const int32_t at[3])
{
    const int blocks = s->chunk < OST_BLOCK ? 1 : s->chunk / OST_BLOCK,
              side = s->chunk < OST_BLOCK ? s->chunk : OST_BLOCK;
    for (int i = 0; i < blocks * blocks * blocks; i++) {
        const int part[3] = {i % blocks, i / blocks % blocks, i / blocks / blocks};
        int32_t first[3], block[3];
        for (int a = 0; a < 3; a++) {
            first[a] = at[a] * s->chunk + part[a] * OST_BLOCK;
            block[a] = first[a] / OST_BLOCK;
        }
        const ost_surface_block *b = ost_surface_block_at(s->bone, block[0], block[1], block[2]);
        const uint32_t mask = side == OST_BLOCK ? UINT32_MAX : ((1u << side) - 1) << (first[0] % OST_BLOCK);
        for (int k = 0; b && k < side; k++)
            for (int j = 0; j < side; j++)
                if (b->occupied[(first[1] % OST_BLOCK + j) + OST_BLOCK * (first[2] % OST_BLOCK + k)] & mask)
                    return true;
    }
    return false;
}

static void count_chunks(const ost_overlay_scene *s, int32_t out[3])
{
    const ost_dims d = s->bone->geometry.dims;
    out[0] = (d.x + s->chunk - 1) / s->chunk;
    out[1] = (d.y + s->chunk - 1) / s->chunk;
    out[2] = (d.z + s->chunk - 1) / s->chunk;
}

static void draw_chunks(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    int32_t n[3], at[3];
    count_chunks(s, n);
    for (int active = 0; active < 2; active++)
        for (at[2] = 0; at[2] < n[2]; at[2]++)
            for (at[1] = 0; at[1] < n[1]; at[1]++)
                for (at[0] = 0; at[0] < n[0]; at[0]++) {
                    float lo[3], hi[3];
                    if (is_active(s, at) != active)
                        continue;
                    chunk_box(s, at, active ? 0.4f : 0, lo, hi);
                    upright(f, e, lo, hi, active ? RED : GREY, active ? 170 : 22, thin(f));
                }
}

/* ------------------------------------------------------------------- boxes */

/* Computes the corners of the tool's box in voxel coordinates of the bone. */
static void tool_corners(const ost_overlay_scene *s, point3 corner[8])
{
    const ost_rotation r = ost_rotation_of(&s->pose);
    const ost_tool_geometry *g = &s->tool_grid;
    const ost_geometry *bone = &s->bone->geometry;
    const double lo[3] = {(double)g->corner.x, (double)g->corner.y, (double)g->corner.z};
    const double size[3] = {(double)g->dims.x * (double)g->voxel, (double)g->dims.y * (double)g->voxel,
                            (double)g->dims.z * (double)g->voxel};
    const double t[3] = {(double)(s->pose.t.x - bone->origin.x), (double)(s->pose.t.y - bone->origin.y),
                         (double)(s->pose.t.z - bone->origin.z)};
    for (int i = 0; i < 8; i++) {
        const double p[3] = {lo[0] + (i & 1 ? size[0] : 0), lo[1] + (i >> 1 & 1 ? size[1] : 0),
                             lo[2] + (i >> 2 ? size[2] : 0)};
        for (int a = 0; a < 3; a++) {
            double v = t[a];
            for (int b = 0; b < 3; b++)
                v += (double)r.m[a][b] / (double)r.n * p[b];
            corner[i].v[a] = (float)(v / (double)bone->spacing.x);
        }
    }
}

/* Intersects the bone's box with the axis-parallel bounding box of the tool. Returns false if the intersection is
   empty. */
static bool meeting(const ost_overlay_scene *s, float lo[3], float hi[3])
{
    point3 corner[8];
    const ost_dims d = s->bone->geometry.dims;
    const float size[3] = {(float)d.x, (float)d.y, (float)d.z};
    tool_corners(s, corner);
    for (int a = 0; a < 3; a++) {
        lo[a] = hi[a] = corner[0].v[a];
        for (int i = 1; i < 8; i++) {
            lo[a] = fminf(lo[a], corner[i].v[a]);
            hi[a] = fmaxf(hi[a], corner[i].v[a]);
        }
        lo[a] = fmaxf(lo[a], -0.5f);
        hi[a] = fminf(hi[a], size[a] - 0.5f);
    }
    return lo[0] < hi[0] && lo[1] < hi[1] && lo[2] < hi[2];
}

void ost_overlay_hit_range(const ost_overlay_scene *s, int32_t lo[3], int32_t hi[3])
{
    float from[3], to[3];
    const bool meet = s->tool && meeting(s, from, to);
    for (int a = 0; a < 3; a++) {
        lo[a] = meet ? (int32_t)floorf((from[a] + 0.5f) / (float)s->chunk) : 0;
        hi[a] = meet ? (int32_t)ceilf((to[a] + 0.5f) / (float)s->chunk) : 0;
    }
}

static void draw_boxes(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    const ost_dims d = s->bone->geometry.dims;
    float lo[3] = {-0.5f, -0.5f, -0.5f}, hi[3] = {(float)d.x - 0.5f, (float)d.y - 0.5f, (float)d.z - 0.5f};
    point3 corner[8];
    upright(f, e, lo, hi, WHITE, 150, thin(f));
    if (!s->tool)
        return;
    tool_corners(s, corner);
    box(f, e, corner, GREEN, FULL, 2 * thin(f));
    if (meeting(s, lo, hi))
        upright(f, e, lo, hi, AMBER, FULL, 2 * thin(f));
}

static void draw_hits(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    int32_t lo[3], hi[3], at[3];
    float from[3], to[3];
    ost_overlay_hit_range(s, lo, hi);
    for (at[2] = lo[2]; at[2] < hi[2]; at[2]++)
        for (at[1] = lo[1]; at[1] < hi[1]; at[1]++)
            for (at[0] = lo[0]; at[0] < hi[0]; at[0]++)
                if (is_active(s, at)) {
                    chunk_box(s, at, 0.4f, from, to);
                    upright(f, e, from, to, RED, 200, thin(f));
                }
    for (int i = 0; i < s->changed; i++) {
        chunk_box(s, s->changed_at[i], 1, from, to);
        upright(f, e, from, to, AMBER, FULL, 2 * thin(f));
    }
}

/* ------------------------------------------------------------------ voxels */

/*
 * A grid of any orientation, given in voxel coordinates of the bone. Used to draw the edges of the voxel faces that are
 * turned to the eye.
 */
typedef struct turned_grid {
    /* position of the grid's origin; column[a]: step from voxel to voxel along axis a of the grid */
    double origin[3], column[3][3];
} turned_grid;

static point3 placed(const turned_grid *g, const double at[3])
{
    point3 p;
    for (int a = 0; a < 3; a++)
        p.v[a] = (float)(g->origin[a] +
                         ((g->column[0][a] * at[0] + g->column[1][a] * at[1]) + g->column[2][a] * at[2]));
    return p;
}

static void face_edges(const ost_frame *f, const ost_eye *e, const turned_grid *g, const int at[3], int face,
                       uint32_t colour, unsigned strength)
{
    const int a = face / 2, b = (a + 1) % 3, c = (a + 2) % 3;
    double middle[3] = {at[0], at[1], at[2]};
    middle[a] += face % 2 ? 0.5 : -0.5;
    const point3 m = placed(g, middle);
    double toward = 0;
    for (int i = 0; i < 3; i++)
        toward += ((double)e->at[i] - (double)m.v[i]) * g->column[a][i] * (face % 2 ? 1 : -1);
    if (!(toward > 0))
        return;
    point3 corner[4];
    for (int i = 0; i < 4; i++) {
        double p[3] = {middle[0], middle[1], middle[2]};
        p[b] += i == 1 || i == 2 ? 0.5 : -0.5;
        p[c] += i >= 2 ? 0.5 : -0.5;
        corner[i] = placed(g, p);
    }
    for (int i = 0; i < 4; i++)
        ost_overlay_line(f, e, corner[i].v, corner[(i + 1) % 4].v, colour, strength, 1);
}

static void draw_voxels(const ost_frame *f, const ost_eye *e, const ost_surface *surface, const turned_grid *g,
                        const float *lo, const float *hi, uint32_t colour)
{
    for (int32_t i = 0; i < surface->used; i++) {
        const ost_surface_block *block = surface->slot[i];
        for (uint32_t p = 0; p < block->count; p++) {
            const uint32_t w = block->points[p];
            const int at[3] = {OST_BLOCK * block->at[0] + (int)(w & 31), OST_BLOCK * block->at[1] + (int)(w >> 5 & 31),
                               OST_BLOCK * block->at[2] + (int)(w >> 10 & 31)};
            bool in = true;
            for (int a = 0; a < 3 && lo; a++)
                in &= (float)at[a] >= lo[a] && (float)at[a] <= hi[a];
            for (uint32_t left = in ? w >> OST_FACES_SHIFT : 0; left; left &= left - 1)
                face_edges(f, e, g, at, __builtin_ctz(left), colour, 90);
        }
    }
}

static void draw_tool_voxels(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    point3 corner[8];
    turned_grid g;
    const double n[3] = {s->tool_grid.dims.x, s->tool_grid.dims.y, s->tool_grid.dims.z};
    tool_corners(s, corner);
    for (int a = 0; a < 3; a++) {
        g.origin[a] = (double)corner[0].v[a];
        for (int b = 0; b < 3; b++) {
            g.column[b][a] = ((double)corner[1 << b].v[a] - (double)corner[0].v[a]) / n[b];
            g.origin[a] += 0.5 * g.column[b][a];
        }
    }
    draw_voxels(f, e, s->tool, &g, NULL, NULL, GREEN);
}

static void draw_bone_voxels(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    const turned_grid g = {.column = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    float lo[3], hi[3];
    if (meeting(s, lo, hi))
        draw_voxels(f, e, s->bone, &g, lo, hi, RED);
}

/* -------------------------------------------------------------------- axis */

static void draw_axis(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    enum { BEFORE_MM = 40, PAST_MM = 12 };
    const ost_geometry *g = &s->bone->geometry;
    const double mm = 1e-9 * (double)g->spacing.x,
                 origin[3] = {1e-9 * (double)g->origin.x, 1e-9 * (double)g->origin.y, 1e-9 * (double)g->origin.z};
    point3 end[2], side = {{e->right[0], e->right[1], e->right[2]}};
    for (int a = 0; a < 3; a++) {
        end[0].v[a] = (float)((s->face_mm[a] - BEFORE_MM * s->inward[a] - origin[a]) / mm);
        end[1].v[a] = (float)((s->face_mm[a] + (s->depth_mm + PAST_MM) * s->inward[a] - origin[a]) / mm);
    }
    ost_overlay_line(f, e, end[0].v, end[1].v, CYAN, FULL, 2 * thin(f));
    for (int i = 0; i <= (int)(s->depth_mm + 0.5); i++) {
        point3 tick[2];
        const float half = (float)((i == 0 || i == (int)(s->depth_mm + 0.5) ? 2.5 : 1.2) / mm);
        for (int a = 0; a < 3; a++) {
            const float at = (float)((s->face_mm[a] + i * s->inward[a] - origin[a]) / mm);
            tick[0].v[a] = at - half * side.v[a];
            tick[1].v[a] = at + half * side.v[a];
        }
        ost_overlay_line(f, e, tick[0].v, tick[1].v, CYAN, FULL, 2 * thin(f));
    }
}

/* Draws a line between two positions in mm. */
static void draw_mm(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s, const double from[3],
                    const double to[3], uint32_t colour, int width)
{
    const ost_geometry *g = &s->bone->geometry;
    const double mm = 1e-9 * (double)g->spacing.x,
                 origin[3] = {1e-9 * (double)g->origin.x, 1e-9 * (double)g->origin.y, 1e-9 * (double)g->origin.z};
    point3 end[2];
    for (int a = 0; a < 3; a++) {
        end[0].v[a] = (float)((from[a] - origin[a]) / mm);
        end[1].v[a] = (float)((to[a] - origin[a]) / mm);
    }
    ost_overlay_line(f, e, end[0].v, end[1].v, colour, FULL, width);
}

/* Draws a cross, 6 mm in size, that faces the eye. */
static void draw_cross(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s, const double at[3],
                       uint32_t colour)
{
    for (int k = 0; k < 2; k++) {
        double end[2][3];
        for (int a = 0; a < 3; a++) {
            const double way = 3 * (double)(k ? e->up[a] : e->right[a]);
            end[0][a] = at[a] - way;
            end[1][a] = at[a] + way;
        }
        draw_mm(f, e, s, end[0], end[1], colour, 3 * thin(f));
    }
}

static void draw_landmarks(const ost_frame *f, const ost_eye *e, const ost_overlay_scene *s)
{
    enum { BEFORE_MM = 30, PAST_MM = 30 };
    double end[2][3];
    for (int a = 0; a < 3; a++) {
        end[0][a] = s->face_mm[a] - BEFORE_MM * s->inward[a];
        end[1][a] = s->face_mm[a] + PAST_MM * s->inward[a];
    }
    draw_mm(f, e, s, s->face_mm, s->trigonum_mm, WHITE, thin(f));
    draw_mm(f, e, s, s->trigonum_mm, s->inferior_mm, WHITE, thin(f));
    draw_mm(f, e, s, s->inferior_mm, s->face_mm, WHITE, thin(f));
    draw_mm(f, e, s, end[0], end[1], CYAN, 2 * thin(f));
    for (int i = 0; i < s->rim_count; i++)
        draw_mm(f, e, s, s->rim_mm[i], s->rim_mm[(i + 1) % s->rim_count], AMBER, 2 * thin(f));
    draw_cross(f, e, s, s->face_mm, CYAN);
    draw_cross(f, e, s, s->trigonum_mm, GREEN);
    draw_cross(f, e, s, s->inferior_mm, GREEN);
}

void ost_overlay_draw(const ost_frame *frame, const ost_eye *eye, unsigned which, const ost_overlay_scene *s)
{
    if (which >> OST_OVERLAY_CHUNKS & 1)
        draw_chunks(frame, eye, s);
    if (which >> OST_OVERLAY_BONE_VOXELS & 1 && s->tool)
        draw_bone_voxels(frame, eye, s);
    if (which >> OST_OVERLAY_TOOL_VOXELS & 1 && s->tool)
        draw_tool_voxels(frame, eye, s);
    if (which >> OST_OVERLAY_HITS & 1)
        draw_hits(frame, eye, s);
    if (which >> OST_OVERLAY_BOXES & 1)
        draw_boxes(frame, eye, s);
    if (which >> OST_OVERLAY_AXIS & 1 && s->planned)
        draw_axis(frame, eye, s);
    if (which >> OST_OVERLAY_LANDMARKS & 1 && s->planned)
        draw_landmarks(frame, eye, s);
}
