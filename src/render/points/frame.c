/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/frame.h"
#include "render/points/light.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef _OPENMP
#include <omp.h>
#endif

static const float FARTHEST = 32768.0f; /* voxels from the eye: squares of distances keep whole voxels apart near the eye's axis */

static void *planes_alloc(size_t count, size_t size)
{
    return aligned_alloc(64, (count * size + 63) / 64 * 64);
}

ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads, ost_error *err)
{
    memset(frame, 0, sizeof *frame);
    if (width < 1 || width > OST_FRAME_MAX || height < 1 || height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; 1 to %d a side are supported", width, height, OST_FRAME_MAX);
    frame->width = width;
    frame->height = height;
    frame->style = style;
    frame->kernels = ost_splat_kernels_of(isa);
#ifdef _OPENMP
    frame->threads = threads ? threads : omp_get_num_procs();
#else
    frame->threads = 1;
#endif
    ost_planes *p = &frame->planes;
    p->stride = (width + OST_LANES - 1) / OST_LANES * OST_LANES;
    const size_t count = (size_t)p->stride * (size_t)height;
    p->distance = planes_alloc(count, sizeof *p->distance);
    p->index = planes_alloc(count, sizeof *p->index);
    p->depth = planes_alloc(count, sizeof *p->depth);
    p->face = planes_alloc(count, sizeof *p->face);
    p->colour = planes_alloc(count, sizeof *p->colour);
    if (!p->distance || !p->index || !p->depth || !p->face || !p->colour) {
        ost_frame_free(frame);
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a frame of %d x %d pixels", width, height);
    }
    memset(p->depth, 0, count * sizeof *p->depth);
    return OST_OK;
}

void ost_frame_free(ost_frame *frame)
{
    free(frame->planes.distance);
    free(frame->planes.index);
    free(frame->planes.depth);
    free(frame->planes.face);
    free(frame->planes.colour);
    free(frame->blocks);
    free(frame->visible.id);
    free(frame->visible.look);
    free(frame->visible.tint);
    free(frame->bases);
    memset(frame, 0, sizeof *frame);
}

static ost_status make_room(ost_frame *f, const ost_surface *s, ost_error *err)
{
    if (s->used > f->block_room) {
        free(f->blocks);
        free(f->bases);
        f->block_room = s->used;
        f->blocks = malloc((size_t)s->used * sizeof *f->blocks);
        f->bases = malloc((size_t)s->used * 4 * sizeof *f->bases);
    }
    /* Every block's list has room for whole vectors. */
    const size_t need = s->points + (size_t)s->used * OST_LANES;
    if (need > f->visible_room) {
        ost_visible *v = &f->visible;
        free(v->id);
        free(v->look);
        free(v->tint);
        f->visible_room = need + need / 4;
        v->id = malloc(f->visible_room * sizeof *v->id);
        v->look = malloc(f->visible_room * sizeof *v->look);
        v->tint = malloc(f->visible_room * sizeof *v->tint);
    }
    if ((s->used && (!f->blocks || !f->bases)) || (need && (!f->visible.id || !f->visible.look || !f->visible.tint))) {
        f->block_room = 0;
        f->visible_room = 0;
        return ost_fail(err, OST_ERR_MEMORY, "no memory to draw %llu surface voxels", (unsigned long long)s->points);
    }
    return OST_OK;
}

/*
 * Whether the block about o (from the eye) may be seen, and in which rows.
 * Its box is taken as one large voxel of half side 16: splat_scalar.c has the
 * reasoning for the slopes; a pixel is added on each side for rounding.
 */
static bool cull(const ost_splat_eye *s, const float o[3], ost_frame_block *b)
{
    const ost_eye *e = &s->eye;
    const float half = (float)OST_BLOCK; /* times reach, which has a half in it */
    const float x = ost_eye_dot(e->right, o), y = ost_eye_dot(e->up, o), z = ost_eye_dot(e->forward, o);
    const float reach = half * s->reach[2], far = z + reach, nearest = z - reach;
    if (!(far > e->near))
        return false;
    b->y0 = 0;
    b->y1 = e->height;
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
    b->y0 = py - hy > 0 ? (int)(py - hy) : 0;
    b->y1 = py + hy < (float)(e->height - 1) ? (int)(py + hy) + 1 : e->height;
    return true;
}

static int by_distance(const void *a, const void *b)
{
    const ost_frame_block *x = a, *y = b;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->slot - y->slot;
}

/* For coordinate i of an axis whose voxel 0 is base from the eye: the faces turned to it, a bit each. */
static void turn(float base, int axis, uint8_t turned[OST_BLOCK])
{
    for (int i = 0; i < OST_BLOCK; i++) {
        const float o = base + (float)i;
        turned[i] = (uint8_t)((o > OST_HALF) << (2 * axis) | (o < -OST_HALF) << (2 * axis + 1));
    }
}

static void choose_blocks(ost_frame *f, const ost_surface *s)
{
    const ost_eye *e = &f->eye.eye;
    f->count = 0;
    for (int32_t i = 0; i < s->used; i++) {
        const ost_surface_block *block = s->slot[i];
        ost_frame_block b = {.slot = i, .count = block->count};
        float middle[3];
        for (int a = 0; a < 3; a++) {
            f->bases[4 * i + a] = (float)(OST_BLOCK * block->at[a]) - e->at[a];
            middle[a] = f->bases[4 * i + a] + 15.5f;
        }
        if (block->count == 0 || !cull(&f->eye, middle, &b))
            continue;
        b.distance = ost_eye_dot(middle, middle);
        f->blocks[f->count++] = b;
    }
    if (f->count > 0)
        qsort(f->blocks, (size_t)f->count, sizeof *f->blocks, by_distance);
    uint32_t begin = 0;
    for (int32_t i = 0; i < f->count; i++) {
        f->blocks[i].begin = begin;
        begin += (f->blocks[i].count + OST_LANES - 1) / OST_LANES * OST_LANES;
    }
}

static void choose_points(const ost_frame *f, const ost_surface *s, const ost_light *light, ost_frame_block *b)
{
    const ost_surface_block *block = s->slot[b->slot];
    uint8_t turned[3][OST_BLOCK];
    for (int a = 0; a < 3; a++)
        turn(f->bases[4 * b->slot + a], a, turned[a]);
    const ost_visible *v = &f->visible;
    b->count = f->kernels.facing(block, (uint32_t)b->slot, turned, v->id + b->begin, v->look + b->begin);
    ost_light_tint(light, v->look + b->begin, b->count, v->tint + b->begin);
}

static void draw_band(const ost_frame *f, int band)
{
    const int y0 = band * OST_BAND, y1 = y0 + OST_BAND < f->height ? y0 + OST_BAND : f->height;
    const size_t at = (size_t)y0 * (size_t)f->planes.stride, count = (size_t)(y1 - y0) * (size_t)f->planes.stride;
    for (size_t i = 0; i < count; i++)
        f->planes.distance[at + i] = INFINITY;
    memset(f->planes.index + at, 0xff, count * sizeof *f->planes.index);
    for (int32_t i = 0; i < f->count; i++) {
        const ost_frame_block *b = &f->blocks[i];
        if (b->y0 < y1 && b->y1 > y0)
            f->kernels.splat(&f->eye, &f->visible, b->begin, b->count, &f->planes, y0, y1);
    }
    for (int y = y0; y < y1; y++)
        f->kernels.resolve(&f->eye, &f->visible, &f->planes, y);
}

ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err)
{
    const ost_dims d = surface->geometry.dims;
    const float size[3] = {(float)d.x, (float)d.y, (float)d.z};
    for (int a = 0; a < 3; a++)
        if (!(fabsf(eye->at[a]) < FARTHEST) || !(fabsf(eye->at[a] - size[a]) < FARTHEST))
            return ost_fail(err, OST_ERR_RANGE, "the camera is more than %d voxels away from the bone's grid", (int)FARTHEST);
    ost_status status = make_room(frame, surface, err);
    if (status != OST_OK)
        return status;
    frame->eye = ost_splat_prepare(eye);
    choose_blocks(frame, surface);
    ost_light light;
    ost_light_make(&light, eye, frame->style);
    frame->visible.bases = frame->bases;
    frame->visible.background = OST_BACKGROUND;
    memcpy(frame->visible.light, light.face, sizeof light.face);
    const int bands = (frame->height + OST_BAND - 1) / OST_BAND;
#pragma omp parallel num_threads(frame->threads)
    {
#pragma omp for schedule(dynamic, 4)
        for (int32_t i = 0; i < frame->count; i++)
            choose_points(frame, surface, &light, &frame->blocks[i]);
#pragma omp for schedule(dynamic, 1)
        for (int band = 0; band < bands; band++)
            draw_band(frame, band);
    }
    return OST_OK;
}

void ost_frame_copy(const ost_frame *frame, ost_picture *picture)
{
    for (int y = 0; y < frame->height; y++) {
        const uint32_t *colour = frame->planes.colour + (size_t)y * (size_t)frame->planes.stride;
        uint8_t *rgb = picture->rgb + 3 * (size_t)y * (size_t)frame->width;
        for (int x = 0; x < frame->width; x++) {
            rgb[3 * x] = (uint8_t)colour[x];
            rgb[3 * x + 1] = (uint8_t)(colour[x] >> 8);
            rgb[3 * x + 2] = (uint8_t)(colour[x] >> 16);
        }
    }
}
