/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/gl/hide.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/gl/pass.h"

enum {
    WORTH = 8,  /* a search is useful if at least 1 in WORTH cells is hidden */
    PAUSE = 8, /* number of frames without a search after a search that was not useful */
};

bool ost_gl_hide_wanted(const ost_gl_variant *v, const ost_gl_layer *l, int number)
{
    return v->occlusion && v->frustum && v->target == OST_GL_COMPACT && !v->true_depth && number == 0 &&
           l->form != OST_GL_VOXELS && l->blocks > 0;
}

static ost_gl_run *run_of(const ost_gl *gl, const ost_gl_layer *l, int32_t i)
{
    return &l->resident->run[l->form][gl->blocks[i].slot];
}

void ost_gl_hide_guess(ost_gl *gl, const ost_gl_layer *l)
{
    bool any = false;
    for (int32_t i = 0; i < l->blocks; i++) {
        gl->wanted[i] = ~run_of(gl, l, i)->hidden;
        any = any || run_of(gl, l, i)->hidden;
    }
    gl->tests_depth = any || l->resident->pause == 0;
    l->resident->pause -= !gl->tests_depth;
}

static void range(float p, float h, int count, int *from, int *to)
{
    const float first = floorf(p - h) - 1, last = floorf(p + h) + 1;
    *from = first > 0 ? first < (float)count ? (int)first : count : 0;
    *to = last < (float)count ? last > 0 ? (int)last + 1 : 0 : count;
    *from /= OST_TILE;
    *to = (*to + OST_TILE - 1) / OST_TILE;
}

/*
 * Returns true if a cube with edges of `side` voxels is hidden, that is, if every pixel that the cube may cover already
 * shows a nearer voxel. `o` is the vector from the eye to the cube's centre. splat_scalar.c derives the slopes.
 */
static bool is_hidden(const ost_gl *gl, const ost_gl_layer *l, const float o[3], int side)
{
    const ost_eye *e = &l->eye.eye;
    const float half = 0.5f * (float)side + 0.01f, z = ost_eye_dot(e->forward, o),
                nearest = z - 2 * half * l->eye.reach[2];
    /*
     * The depth of a point is that of its voxel's centre, and the depth of a brick is that of the brick's centre. On
     * each axis, the distance of such a centre from the cube's centre is at most `centres`.
     */
    const float centres = 0.5f * (float)(side - (l->form == OST_GL_BRICKS ? 4 : 1));
    float square = 0, sx = 0, sy = 0;
    int x0, x1, y0, y1;
    if (!(nearest > e->near))
        return false;
    const float tx = ost_eye_dot(e->right, o) / z, ty = ost_eye_dot(e->up, o) / z, k = half * e->focal / nearest;
    for (int a = 0; a < 3; a++) {
        const float off = fabsf(o[a]) - centres;
        square += off > 0 ? off * off : 0;
        sx += fabsf(e->right[a] - tx * e->forward[a]);
        sy += fabsf(e->up[a] - ty * e->forward[a]);
    }
    range(e->half_w + tx * e->focal, sx * k, e->width, &x0, &x1);
    range(e->half_h - ty * e->focal, sy * k, e->height, &y0, &y1);
    const float depth = 0.9999f * square * l->depth_scale - l->depth_slack;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (gl->targets.farthest[y * gl->targets.across + x] > depth)
                return false;
    return true;
}

/* Returns the set of the hidden cells of a block. `base` is the vector from the eye to the block's first voxel. */
static uint64_t hidden_cells(const ost_gl *gl, const ost_gl_layer *l, const ost_gl_run *run, const float base[3])
{
    enum { CELL = 8 };
    uint64_t hidden = 0;
    float o[3];
    for (int a = 0; a < 3; a++)
        o[a] = base[a] + 0.5f * (float)(OST_BLOCK - 1);
    if (is_hidden(gl, l, o, OST_BLOCK))
        return run->cells;
    for (uint64_t left = run->cells; left; left &= left - 1) {
        const int cell = __builtin_ctzll(left);
        for (int a = 0; a < 3; a++)
            o[a] = base[a] + (float)(CELL * (cell >> (2 * a) & 3)) + 0.5f * (float)(CELL - 1);
        hidden |= (uint64_t)is_hidden(gl, l, o, CELL) << cell;
    }
    return hidden;
}

/* Computes the maximum depth of each tile. Depths are compared as integers by their bit patterns, which gives the
   same order because no depth is negative. */
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

static ost_status test_depths(ost_gl *gl, const ost_gl_variant *v, ost_error *err)
{
    ost_gl_targets *t = &gl->targets;
    if (v->tiles || !gl->context.info.software)
        return ost_gl_read_tiles(gl, err);
    if (!t->depths)
        t->depths = malloc((size_t)t->width * (size_t)t->height * sizeof *t->depths);
    if (!t->depths)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the depths of %d x %d pixels", t->width, t->height);
    ost_status status = ost_gl_read_depths(gl, t->depths, err);
    if (status == OST_OK)
        find_tiles(t);
    return status;
}

ost_status ost_gl_hide_test(ost_gl *gl, const ost_gl_variant *v, const ost_gl_layer *l, bool *missing, ost_error *err)
{
    uint32_t all = 0, hidden = 0;
    *missing = false;
    if (!gl->tests_depth)
        return OST_OK;
    ost_status status = test_depths(gl, v, err);
    if (status != OST_OK)
        return status;
    for (int32_t i = 0; i < l->blocks; i++) {
        ost_gl_run *run = run_of(gl, l, i);
        const uint64_t before = run->hidden;
        run->hidden = hidden_cells(gl, l, run, gl->bases + 4 * gl->blocks[i].slot);
        gl->wanted[i] = before & ~run->hidden;
        *missing = *missing || gl->wanted[i];
        all += (uint32_t)__builtin_popcountll(run->cells);
        hidden += (uint32_t)__builtin_popcountll(run->hidden);
        gl->did.hidden += (uint32_t)__builtin_popcountll(before & run->hidden);
    }
    if (WORTH * hidden >= all)
        return OST_OK;
    for (int32_t i = 0; i < l->blocks; i++)
        run_of(gl, l, i)->hidden = 0;
    l->resident->pause = PAUSE;
    return OST_OK;
}
