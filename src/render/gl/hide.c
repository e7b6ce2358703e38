/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/gl/hide.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/gl/pass.h"

enum {
    WORTH = 8,  /* of so many points one must be hidden for the look to be worth its time */
    PAUSE = 8, /* frames until it is looked again where none was worth it */
};

bool ost_gl_hide_wanted(const ost_gl_variant *v, const ost_gl_layer *l, int number)
{
    return v->occlusion && v->frustum && v->target == OST_GL_COMPACT && !v->true_depth && number == 0 && l->form != OST_GL_VOXELS && l->blocks > 0;
}

static ost_gl_run *run_of(const ost_gl *gl, const ost_gl_layer *l, int32_t i)
{
    return &l->resident->run[l->form][gl->blocks[i].slot];
}

/* Blocks from..l->blocks that are hidden go behind those that are not, each in their order; returns where they begin. */
static int32_t part(ost_gl *gl, const ost_gl_layer *l, int32_t from)
{
    int32_t n = from, behind = 0;
    for (int32_t i = from; i < l->blocks; i++)
        if (run_of(gl, l, i)->hidden)
            gl->behind[behind++] = gl->blocks[i];
        else
            gl->blocks[n++] = gl->blocks[i];
    memcpy(gl->blocks + n, gl->behind, (size_t)behind * sizeof *gl->behind);
    return n;
}

void ost_gl_hide_order(ost_gl *gl, ost_gl_layer *l)
{
    l->from = 0;
    l->to = part(gl, l, 0);
    gl->look = l->to < l->blocks || l->resident->pause == 0;
    l->resident->pause -= !gl->look;
}

/* Tiles that a box may cover, half-open, and the least depth in it. */
typedef struct sight {
    int x0, x1, y0, y1;
    float depth;
} sight;

static void range(float lo, float hi, int count, int *from, int *to)
{
    const float first = floorf(lo) - 1, last = floorf(hi) + 1;
    *from = first > 0 ? first < (float)count ? (int)first : count : 0;
    *to = last < (float)count ? last > 0 ? (int)last + 1 : 0 : count;
    *from /= OST_TILE;
    *to = (*to + OST_TILE - 1) / OST_TILE;
}

/* The projection of a box in front of the eye lies within that of its corners; false where it is not in front. */
static bool sight_of(const ost_gl_layer *l, const ost_gl_run *run, const float base[3], sight *out)
{
    const ost_eye *e = &l->eye.eye;
    const bool bricks = l->form == OST_GL_BRICKS;
    float side[2][3], square = 0, px[2] = {INFINITY, -INFINITY}, py[2] = {INFINITY, -INFINITY};
    for (int a = 0; a < 3; a++) {
        /* Of points the depth is their centre's, of bricks that of 4^3 voxels. */
        const float lo = base[a] + (bricks ? (float)(run->lo[a] & ~3) + 1.5f : (float)run->lo[a]);
        const float hi = base[a] + (bricks ? (float)(run->hi[a] & ~3) + 1.5f : (float)run->hi[a]);
        const float off = lo > -hi ? lo : -hi;
        square += off > 0 ? off * off : 0;
        side[0][a] = base[a] + (float)run->lo[a] - 0.51f;
        side[1][a] = base[a] + (float)run->hi[a] + 0.51f;
    }
    for (int i = 0; i < 8; i++) {
        const float corner[3] = {side[i & 1][0], side[i >> 1 & 1][1], side[i >> 2][2]};
        const float z = ost_eye_dot(e->forward, corner);
        if (!(z > e->near))
            return false;
        const float x = e->half_w + ost_eye_dot(e->right, corner) / z * e->focal, y = e->half_h - ost_eye_dot(e->up, corner) / z * e->focal;
        px[0] = fminf(px[0], x);
        px[1] = fmaxf(px[1], x);
        py[0] = fminf(py[0], y);
        py[1] = fmaxf(py[1], y);
    }
    range(px[0], px[1], e->width, &out->x0, &out->x1);
    range(py[0], py[1], e->height, &out->y0, &out->y1);
    out->depth = 0.9999f * square * l->depth_scale - l->depth_slack;
    return true;
}

static bool is_hidden(const ost_gl *gl, const ost_gl_layer *l, const ost_gl_run *run, const float base[3])
{
    sight s;
    if (!sight_of(l, run, base, &s))
        return false;
    for (int y = s.y0; y < s.y1; y++)
        for (int x = s.x0; x < s.x1; x++)
            if (gl->targets.farthest[y * gl->targets.across + x] > s.depth)
                return false;
    return true;
}

/* The greatest of each tile's depths. Depths are no less than 0: as integers they are in the same order. */
static void find_tiles(const ost_gl_targets *t)
{
    int32_t column[OST_FRAME_MAX];
    const size_t width = (size_t)t->width;
    for (int y = 0; y < t->height; y++) {
        const char *row = (const char *)(t->depths + (size_t)y * width);
        for (size_t x = 0; x < width; x++) {
            int32_t depth;
            memcpy(&depth, row + x * sizeof depth, sizeof depth);
            column[x] = y % OST_TILE == 0 || depth > column[x] ? depth : column[x];
        }
        if (y % OST_TILE != OST_TILE - 1 && y != t->height - 1)
            continue;
        float *tiles = t->farthest + (size_t)(y / OST_TILE) * (size_t)t->across;
        for (size_t x = 0; x < width; x++) {
            float depth;
            memcpy(&depth, &column[x], sizeof depth);
            tiles[x / OST_TILE] = x % OST_TILE == 0 || depth > tiles[x / OST_TILE] ? depth : tiles[x / OST_TILE];
        }
    }
}

static ost_status look_at_depths(ost_gl *gl, const ost_gl_variant *v, ost_error *err)
{
    ost_gl_targets *t = &gl->targets;
    if (v->tiles || !gl->context.info.software)
        return ost_gl_read_tiles(gl, err);
    if (!t->depths)
        t->depths = malloc((size_t)t->width * (size_t)t->height * sizeof *t->depths);
    if (!t->depths)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for the depths of %d x %d pixels", t->width, t->height);
    ost_status status = ost_gl_read_depths(gl, t->depths, err);
    if (status == OST_OK)
        find_tiles(t);
    return status;
}

ost_status ost_gl_hide_look(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l, ost_error *err)
{
    uint64_t all = 0, hidden = 0;
    const int32_t drawn = l->to;
    l->from = l->to;
    if (!gl->look)
        return OST_OK;
    ost_status status = look_at_depths(gl, v, err);
    if (status != OST_OK)
        return status;
    for (int32_t i = 0; i < l->blocks; i++) {
        ost_gl_run *run = run_of(gl, l, i);
        run->hidden = is_hidden(gl, l, run, gl->bases + 4 * gl->blocks[i].slot);
        all += run->count;
        hidden += run->hidden ? run->count : 0;
    }
    l->to = part(gl, l, drawn);
    gl->did.hidden = l->blocks - l->to;
    if (WORTH * hidden >= all)
        return OST_OK;
    for (int32_t i = 0; i < l->blocks; i++)
        run_of(gl, l, i)->hidden = false;
    l->resident->pause = PAUSE;
    return OST_OK;
}
