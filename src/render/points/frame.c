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

static void *plane_alloc(size_t count, size_t size)
{
    return aligned_alloc(64, (count * size + 63) / 64 * 64);
}

static bool planes_init(ost_planes *p, int width, int height)
{
    p->stride = (width + OST_LANES - 1) / OST_LANES * OST_LANES;
    const size_t count = (size_t)p->stride * (size_t)height;
    p->distance = plane_alloc(count, sizeof *p->distance);
    p->index = plane_alloc(count, sizeof *p->index);
    p->depth = plane_alloc(count, sizeof *p->depth);
    p->face = plane_alloc(count, sizeof *p->face);
    p->colour = plane_alloc(count, sizeof *p->colour);
    if (!p->distance || !p->index || !p->depth || !p->face || !p->colour)
        return false;
    memset(p->depth, 0, count * sizeof *p->depth);
    return true;
}

static void planes_free(ost_planes *p)
{
    free(p->distance);
    free(p->index);
    free(p->depth);
    free(p->face);
    free(p->colour);
    *p = (ost_planes){0};
}

static ost_status no_memory(const ost_frame *f, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "no memory for a frame of %d x %d pixels", f->width, f->height);
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
    if (!planes_init(&frame->planes, width, height)) {
        ost_status status = no_memory(frame, err);
        ost_frame_free(frame);
        return status;
    }
    return OST_OK;
}

static void layer_free(ost_frame_layer *layer)
{
    free(layer->blocks);
    free(layer->visible.id);
    free(layer->visible.look);
    free(layer->visible.tint);
    free(layer->bases);
}

void ost_frame_free(ost_frame *frame)
{
    planes_free(&frame->planes);
    planes_free(&frame->over);
    for (int i = 0; i < OST_FRAME_LAYERS; i++)
        layer_free(&frame->layer[i]);
    memset(frame, 0, sizeof *frame);
}

static ost_status make_room(ost_frame_layer *f, ost_error *err)
{
    const ost_surface *s = f->surface;
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

static void choose_blocks(ost_frame_layer *f)
{
    const ost_surface *s = f->surface;
    const ost_eye *e = &f->eye.eye;
    f->count = 0;
    f->y0 = f->y1 = 0;
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
        f->y0 = f->count == 1 || b.y0 < f->y0 ? b.y0 : f->y0;
        f->y1 = f->count == 1 || b.y1 > f->y1 ? b.y1 : f->y1;
    }
    if (f->count > 0)
        qsort(f->blocks, (size_t)f->count, sizeof *f->blocks, by_distance);
    uint32_t begin = 0;
    for (int32_t i = 0; i < f->count; i++) {
        f->blocks[i].begin = begin;
        begin += (f->blocks[i].count + OST_LANES - 1) / OST_LANES * OST_LANES;
    }
}

static void choose_points(const ost_frame *frame, const ost_frame_layer *f, ost_frame_block *b)
{
    const ost_surface_block *block = f->surface->slot[b->slot];
    uint8_t turned[3][OST_BLOCK];
    for (int a = 0; a < 3; a++)
        turn(f->bases[4 * b->slot + a], a, turned[a]);
    const ost_visible *v = &f->visible;
    b->count = frame->kernels.facing(block, (uint32_t)b->slot, turned, v->id + b->begin, v->look + b->begin);
    ost_light_tint(&f->light, v->look + b->begin, b->count, v->tint + b->begin);
}

static void draw_layer(const ost_frame *f, const ost_frame_layer *layer, const ost_planes *planes, int y0, int y1)
{
    const size_t at = (size_t)y0 * (size_t)planes->stride, count = (size_t)(y1 - y0) * (size_t)planes->stride;
    for (size_t i = 0; i < count; i++)
        planes->distance[at + i] = INFINITY;
    memset(planes->index + at, 0xff, count * sizeof *planes->index);
    for (int32_t i = 0; i < layer->count; i++) {
        const ost_frame_block *b = &layer->blocks[i];
        if (b->y0 < y1 && b->y1 > y0)
            f->kernels.splat(&layer->eye, &layer->visible, b->begin, b->count, planes, y0, y1);
    }
    for (int y = y0; y < y1; y++)
        f->kernels.resolve(&layer->eye, &layer->visible, planes, y);
}

/* Of each pixel what is nearer; of the same depth what was there. */
static void merge(const ost_planes *to, const ost_planes *from, float scale, int y0, int y1)
{
    const size_t at = (size_t)y0 * (size_t)to->stride, end = (size_t)y1 * (size_t)to->stride;
    for (size_t i = at; i < end; i++) {
        const float depth = from->depth[i] * scale;
        if (from->face[i] == OST_NO_FACE || (to->face[i] != OST_NO_FACE && !(depth < to->depth[i])))
            continue;
        to->depth[i] = depth;
        to->face[i] = from->face[i];
        to->colour[i] = from->colour[i];
        to->index[i] = OST_NO_VOXEL;
    }
}

static void draw_band(const ost_frame *f, int band)
{
    const int y0 = band * OST_BAND, y1 = y0 + OST_BAND < f->height ? y0 + OST_BAND : f->height;
    draw_layer(f, &f->layer[0], &f->planes, y0, y1);
    for (int i = 1; i < f->layers; i++) {
        const ost_frame_layer *layer = &f->layer[i];
        const int from = layer->y0 > y0 ? layer->y0 : y0, to = layer->y1 < y1 ? layer->y1 : y1;
        if (from >= to)
            continue;
        draw_layer(f, layer, &f->over, from, to);
        merge(&f->planes, &f->over, layer->scale, from, to);
    }
}

static ost_status check_thing(const ost_frame_thing *thing, ost_error *err)
{
    const ost_dims d = thing->surface->geometry.dims;
    const float size[3] = {(float)d.x, (float)d.y, (float)d.z};
    for (int a = 0; a < 3; a++)
        if (!(fabsf(thing->eye.at[a]) < FARTHEST) || !(fabsf(thing->eye.at[a] - size[a]) < FARTHEST))
            return ost_fail(err, OST_ERR_RANGE, "the camera is more than %d voxels away from what it is to see", (int)FARTHEST);
    return OST_OK;
}

static ost_status prepare(ost_frame *frame, const ost_frame_thing *thing, int number, ost_error *err)
{
    ost_frame_layer *layer = &frame->layer[number];
    layer->surface = thing->surface;
    ost_status status = check_thing(thing, err);
    if (status == OST_OK)
        status = make_room(layer, err);
    if (status != OST_OK)
        return status;
    layer->eye = ost_splat_prepare(&thing->eye);
    layer->scale = (float)((double)thing->surface->geometry.spacing.x / (double)frame->layer[0].surface->geometry.spacing.x);
    choose_blocks(layer);
    ost_light_make(&layer->light, &thing->eye, frame->style, thing->paint);
    layer->visible.bases = layer->bases;
    layer->visible.background = OST_BACKGROUND;
    memcpy(layer->visible.light, layer->light.face, sizeof layer->light.face);
    return OST_OK;
}

ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err)
{
    ost_status status = OST_OK;
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d things to draw; 1 to %d are supported", count, OST_FRAME_LAYERS);
    if (count > 1 && !frame->over.colour && !planes_init(&frame->over, frame->width, frame->height)) {
        planes_free(&frame->over);
        return no_memory(frame, err);
    }
    for (int i = 0; i < count && status == OST_OK; i++)
        status = prepare(frame, &things[i], i, err);
    if (status != OST_OK)
        return status;
    frame->layers = count;
    const int bands = (frame->height + OST_BAND - 1) / OST_BAND;
#pragma omp parallel num_threads(frame->threads)
    {
        for (int l = 0; l < count; l++) {
            ost_frame_layer *layer = &frame->layer[l];
#pragma omp for schedule(dynamic, 4)
            for (int32_t i = 0; i < layer->count; i++)
                choose_points(frame, layer, &layer->blocks[i]);
        }
#pragma omp for schedule(dynamic, 1)
        for (int band = 0; band < bands; band++)
            draw_band(frame, band);
    }
    return OST_OK;
}

ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err)
{
    const ost_frame_thing bone = {surface, *eye, OST_PAINT_BONE};
    return ost_frame_draw_things(frame, &bone, 1, err);
}

void ost_colours_copy(const uint32_t *colours, int stride, ost_picture *picture)
{
    for (int y = 0; y < picture->height; y++) {
        const uint32_t *colour = colours + (size_t)y * (size_t)stride;
        uint8_t *rgb = picture->rgb + 3 * (size_t)y * (size_t)picture->width;
        for (int x = 0; x < picture->width; x++) {
            rgb[3 * x] = (uint8_t)colour[x];
            rgb[3 * x + 1] = (uint8_t)(colour[x] >> 8);
            rgb[3 * x + 2] = (uint8_t)(colour[x] >> 16);
        }
    }
}

void ost_frame_copy(const ost_frame *frame, ost_picture *picture)
{
    ost_colours_copy(frame->planes.colour, frame->planes.stride, picture);
}
