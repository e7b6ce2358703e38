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

static void *plane_alloc(size_t count, size_t size)
{
    return aligned_alloc(64, (count * size + 63) / 64 * 64);
}

static bool planes_init(ost_planes *p, int width, int height)
{
    p->stride = (width + OST_LANES - 1) / OST_LANES * OST_LANES;
    const size_t count = (size_t)p->stride * (size_t)height;
    p->depth = plane_alloc(count, sizeof *p->depth);
    p->face = plane_alloc(count, sizeof *p->face);
    p->colour = plane_alloc(count, sizeof *p->colour);
    if (!p->depth || !p->face || !p->colour)
        return false;
    memset(p->depth, 0, count * sizeof *p->depth);
    return true;
}

static bool keys_init(ost_planes *p, int height)
{
    const size_t size = (size_t)p->stride * (size_t)height * sizeof *p->key;
    p->key = plane_alloc(size, 1);
    if (p->key)
        memset(p->key, OST_EMPTY_BYTE, size);
    return p->key != NULL;
}

static void planes_free(ost_planes *p)
{
    free(p->key);
    free(p->depth);
    free(p->face);
    free(p->colour);
    *p = (ost_planes){0};
}

static ost_status no_memory(const ost_frame *f, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "no memory for a frame of %d x %d pixels", f->width, f->height);
}

static bool benches_init(ost_frame *f)
{
    const size_t tiles = (size_t)f->tiles_across * (size_t)(f->band / OST_TILE);
    f->bench = calloc((size_t)f->threads, sizeof *f->bench);
    for (int i = 0; f->bench && i < f->threads; i++) {
        ost_frame_bench *b = &f->bench[i];
        b->tiles = malloc(tiles * sizeof *b->tiles);
        if (!planes_init(&b->over, f->width, f->band) || !keys_init(&b->over, f->band) || !b->tiles)
            return false;
    }
    return f->bench != NULL;
}

static void benches_free(ost_frame *f)
{
    for (int i = 0; f->bench && i < f->threads; i++) {
        planes_free(&f->bench[i].over);
        free(f->bench[i].tiles);
    }
    free(f->bench);
}

ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads, ost_error *err)
{
    memset(frame, 0, sizeof *frame);
    if (width < 1 || width > OST_FRAME_MAX || height < 1 || height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; 1 to %d a side are supported", width, height, OST_FRAME_MAX);
    frame->width = width;
    frame->height = height;
    frame->style = style;
    frame->band = OST_BAND;
    frame->kernels = ost_splat_kernels_of(isa);
    frame->tint = ost_light_tint_for(isa);
#ifdef _OPENMP
    frame->threads = threads ? threads : omp_get_num_procs();
#else
    frame->threads = 1;
#endif
    const bool planes = planes_init(&frame->planes, width, height);
    frame->blank = malloc((size_t)frame->planes.stride * sizeof *frame->blank);
    frame->tiles_across = frame->planes.stride / OST_TILE;
    frame->directions = malloc(sizeof *frame->directions);
    if (frame->directions)
        ost_directions_make(frame->directions);
    if (!planes || !frame->directions || !frame->blank || !benches_init(frame)) {
        ost_status status = no_memory(frame, err);
        ost_frame_free(frame);
        return status;
    }
    for (int x = 0; x < frame->planes.stride; x++)
        frame->blank[x] = OST_BACKGROUND;
    return OST_OK;
}

ost_status ost_frame_keep_keys(ost_frame *frame, ost_error *err)
{
    return frame->planes.key || keys_init(&frame->planes, frame->height) ? OST_OK : no_memory(frame, err);
}

static void layer_free(ost_frame_layer *layer)
{
    free(layer->blocks);
    free(layer->visible.id);
    free(layer->visible.look);
    free(layer->visible.tint);
    free(layer->visible.only);
    free(layer->visible.rows);
    free(layer->bases);
}

void ost_frame_free(ost_frame *frame)
{
    planes_free(&frame->planes);
    planes_free(&frame->ghost);
    benches_free(frame);
    free(frame->blank);
    free(frame->directions);
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
    ost_visible *v = &f->visible;
    if (need > f->visible_room) {
        free(v->id);
        free(v->look);
        free(v->tint);
        free(v->only);
        free(v->rows);
        f->visible_room = need + need / 4;
        v->id = malloc(f->visible_room * sizeof *v->id);
        v->look = malloc(f->visible_room * sizeof *v->look);
        v->tint = malloc(f->visible_room * sizeof *v->tint);
        v->only = malloc(f->visible_room * sizeof *v->only);
        v->rows = malloc((f->visible_room / OST_LANES + 1) * sizeof(_Atomic uint32_t));
    }
    if ((s->used && (!f->blocks || !f->bases)) || (need && (!v->id || !v->look || !v->tint || !v->only || !v->rows))) {
        f->block_room = 0;
        f->visible_room = 0;
        return ost_fail(err, OST_ERR_MEMORY, "no memory to draw %llu surface voxels", (unsigned long long)s->points);
    }
    return OST_OK;
}

static void widen_spans(ost_frame_layer *f, const ost_frame_block *b)
{
    const int from = b->x0 / OST_LANES * OST_LANES, to = (b->x1 + OST_LANES - 1) / OST_LANES * OST_LANES;
    for (int i = b->y0 / OST_SPAN_ROWS; i <= (b->y1 - 1) / OST_SPAN_ROWS; i++) {
        ost_frame_span *s = &f->span[i];
        *s = s->from == s->to ? (ost_frame_span){from, to} : (ost_frame_span){from < s->from ? from : s->from, to > s->to ? to : s->to};
    }
}

static void find_spans(ost_frame_layer *f)
{
    for (int i = 0; i <= (f->eye.eye.height - 1) / OST_SPAN_ROWS; i++)
        f->span[i] = (ost_frame_span){0, 0};
    for (int32_t i = 0; i < f->count; i++)
        widen_spans(f, &f->blocks[i]);
}

static void choose_points(const ost_frame *frame, const ost_frame_layer *f, ost_frame_block *b)
{
    const ost_surface_block *block = f->surface->slot[b->slot];
    uint8_t turned[3][OST_BLOCK];
    for (int a = 0; a < 3; a++)
        ost_blocks_turned(f->bases[4 * b->slot + a], a, turned[a]);
    const ost_visible *v = &f->visible;
    b->count = frame->kernels.facing(block, (uint32_t)b->slot, turned, v, b->begin);
    if (f->within)
        memset(v->only + b->begin, OST_SEVERAL, b->count);
    for (uint32_t i = b->begin / OST_LANES; i < (b->begin + b->count + OST_LANES - 1) / OST_LANES; i++)
        atomic_store_explicit(&v->rows[i], OST_ROWS_UNKNOWN, memory_order_relaxed);
    frame->tint(&f->light, v->look + b->begin, b->count, v->tint + b->begin);
    b->listed = true;
}

static ost_frame_span span_of(const ost_frame_layer *layer, int y)
{
    return layer->span[y / OST_SPAN_ROWS];
}

static void clear(const ost_planes *planes, int y, ost_frame_span s)
{
    memset(ost_key_row(planes, y) + s.from, OST_EMPTY_BYTE, (size_t)(s.to - s.from) * sizeof *planes->key);
}

/* No face where nothing can be. */
static void bare(const ost_planes *planes, int y, ost_frame_span s)
{
    uint8_t *row = planes->face + ost_row(planes, y);
    memset(row, OST_NO_FACE, (size_t)s.from);
    memset(row + s.to, OST_NO_FACE, (size_t)(planes->stride - s.to));
}

/* And background. */
static void blank(const ost_frame *f, int y, ost_frame_span s)
{
    uint32_t *row = f->planes.colour + ost_row(&f->planes, y);
    memcpy(row, f->blank, (size_t)s.from * sizeof *row);
    memcpy(row + s.to, f->blank, (size_t)(f->planes.stride - s.to) * sizeof *row);
}

/* A band's rows, y0 <= y < y1, and where it is drawn. */
typedef struct band {
    int y0, y1;
    ost_frame_bench *bench;
} band;

/* The tiles of a band that a block may cover, half-open; rows from the band's first on. */
typedef struct tile_range {
    int x0, x1, y0, y1;
} tile_range;

static tile_range tiles_of(const ost_frame_block *b, const band *at)
{
    const int top = b->y0 > at->y0 ? b->y0 : at->y0, end = b->y1 < at->y1 ? b->y1 : at->y1;
    return (tile_range){b->x0 / OST_TILE, (b->x1 + OST_TILE - 1) / OST_TILE, (top - at->y0) / OST_TILE, (end - at->y0 + OST_TILE - 1) / OST_TILE};
}

/* Whether all of the tiles are covered by what is nearer than key. */
static bool hidden(const ost_frame *f, const band *at, const ost_planes *planes, tile_range r, uint64_t key)
{
    for (int y = r.y0; y < r.y1; y++)
        for (int x = r.x0; x < r.x1; x++) {
            ost_frame_tile *t = &at->bench->tiles[y * f->tiles_across + x];
            const int top = at->y0 + y * OST_TILE, rows = at->y1 - top < OST_TILE ? at->y1 - top : OST_TILE;
            if (t->farthest < key)
                continue;
            if (!t->stale)
                return false;
            *t = (ost_frame_tile){f->kernels.farthest(planes, x * OST_TILE, top, rows), false};
            if (t->farthest >= key)
                return false;
        }
    return true;
}

static void drawn(const ost_frame *f, const band *at, tile_range r)
{
    for (int y = r.y0; y < r.y1; y++)
        for (int x = r.x0; x < r.x1; x++)
            at->bench->tiles[y * f->tiles_across + x].stale = true;
}

static void draw_layer(const ost_frame *f, const ost_frame_layer *layer, const band *at, const ost_planes *planes)
{
    for (int y = at->y0; y < at->y1; y++)
        clear(planes, y, span_of(layer, y));
    for (int i = 0; i < f->tiles_across * (f->band / OST_TILE); i++)
        at->bench->tiles[i] = (ost_frame_tile){OST_EMPTY_KEY, false};
    for (int32_t i = 0; i < layer->count; i++) {
        ost_frame_block *b = &layer->blocks[i];
        if (b->y0 >= at->y1 || b->y1 <= at->y0)
            continue;
        const tile_range r = tiles_of(b, at);
        if (hidden(f, at, planes, r, b->nearest))
            continue;
        if (!b->listed)
            choose_points(f, layer, b);
        f->kernels.splat(&layer->eye, &layer->visible, b->begin, b->count, planes, at->y0, at->y1);
        drawn(f, at, r);
    }
    for (int y = at->y0; y < at->y1; y++) {
        const ost_frame_span s = span_of(layer, y);
        f->kernels.resolve(&layer->eye, &layer->visible, planes, y, s.from, s.to);
        bare(planes, y, s);
    }
}

static uint32_t mixed(uint32_t under, uint32_t over, uint32_t share)
{
    const uint32_t rest = 256 - share;
    return (((under & 0xff00ff) * rest + (over & 0xff00ff) * share) >> 8 & 0xff00ff) | (((under & 0xff00) * rest + (over & 0xff00) * share) >> 8 & 0xff00);
}

/* Whether a layer has something at a pixel of the planes that it was drawn into. */
static bool is_there(const ost_frame *f, const ost_frame_layer *layer, int x, int y)
{
    const ost_frame_span span = span_of(layer, y);
    return x >= span.from && x < span.to && f->ghost.face[ost_row(&f->ghost, y) + (size_t)x] != OST_NO_FACE;
}

/* What can be seen through, with its outline, in row y: it leaves all but the colour as it was. */
static void merge_ghost(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y)
{
    enum { LINE = 100 };
    const ost_frame_span span = span_of(layer, y);
    const ost_planes *to = &f->planes, *from = &f->ghost;
    for (int x = span.from; x < span.to && x < f->width; x++) {
        const size_t i = ost_row(to, y) + (size_t)x;
        if (from->face[i] == OST_NO_FACE)
            continue;
        const bool before = to->face[i] == OST_NO_FACE || from->depth[i] * layer->scale < to->depth[i];
        const bool edge = (x > 0 && !is_there(f, layer, x - 1, y)) || (x + 1 < f->width && !is_there(f, layer, x + 1, y)) ||
                          (y > 0 && !is_there(f, layer, x, y - 1)) || (y + 1 < f->height && !is_there(f, layer, x, y + 1));
        const uint32_t share = (before ? ghost : ghost / 2) + (edge ? LINE : 0);
        to->colour[i] = mixed(to->colour[i], edge ? layer->light.colour[0] : from->colour[i], share < 256 ? share : 256);
    }
}

static int thread_number(void)
{
#ifdef _OPENMP
    return omp_get_thread_num();
#else
    return 0;
#endif
}

/* A band of rows, and a copy of the planes with its keys where none are kept. */
static band band_of(const ost_frame *f, int number, ost_planes *planes)
{
    const int y0 = number * f->band;
    const band at = {y0, y0 + f->band < f->height ? y0 + f->band : f->height, &f->bench[thread_number()]};
    if (!planes->key) {
        planes->key = at.bench->over.key;
        planes->key_top = y0;
    }
    return at;
}

static void draw_band(const ost_frame *f, int number)
{
    ost_planes planes = f->planes;
    const band at = band_of(f, number, &planes);
    ost_planes over = at.bench->over;
    over.top = over.key_top = at.y0;
    draw_layer(f, &f->layer[0], &at, &planes);
    for (int y = at.y0; y < at.y1; y++)
        blank(f, y, span_of(&f->layer[0], y));
    for (int i = 1; i < f->layers; i++) {
        const ost_frame_layer *layer = &f->layer[i];
        if (layer->y0 >= at.y1 || layer->y1 <= at.y0)
            continue;
        draw_layer(f, layer, &at, &over);
        for (int y = at.y0; y < at.y1; y++)
            f->kernels.merge(&planes, &over, layer->scale, y, span_of(layer, y).from, span_of(layer, y).to);
    }
}

/*
 * Whether a ray may come upon a voxel by a face that is not to the air: it
 * begins in a voxel, or it has passed one that the near plane takes away.
 * Such a voxel's middle is within near + sqrt(3) of the eye along forward, so
 * its corners are within near + 2 sqrt(3), and along a ray that is c times as
 * far, c = 1 / cosine of the angle to the frame's corner.
 */
static bool is_within(const ost_surface *surface, const ost_eye *e)
{
    enum { MOST = 24 };
    const float corner = sqrtf((e->focal * e->focal + e->half_w * e->half_w) + e->half_h * e->half_h) / e->focal;
    const float reach = (e->near + 3.5f) * corner + 1;
    int32_t lo[3], hi[3];
    if (!(reach < (float)MOST))
        return true;
    for (int a = 0; a < 3; a++) {
        lo[a] = (int32_t)floorf(e->at[a] - reach);
        hi[a] = (int32_t)ceilf(e->at[a] + reach);
    }
    return !ost_surface_is_bare(surface, lo, hi);
}

static ost_status prepare(ost_frame *frame, const ost_frame_thing *thing, int number, ost_pm spacing, ost_error *err)
{
    ost_frame_layer *layer = &frame->layer[number];
    layer->surface = thing->surface;
    ost_status status = ost_blocks_check(thing->surface, &thing->eye, err);
    if (status == OST_OK)
        status = make_room(layer, err);
    if (status != OST_OK)
        return status;
    layer->eye = ost_splat_prepare(&thing->eye);
    layer->scale = (float)((double)thing->surface->geometry.spacing.x / (double)spacing);
    ost_blocks_choose(layer->surface, &layer->eye, layer->blocks, layer->bases, &layer->count, &layer->y0, &layer->y1);
    find_spans(layer);
    layer->within = is_within(thing->surface, &thing->eye);
    ost_light_make(&layer->light, frame->directions, &thing->eye, frame->style, thing->paint, thing->palette);
    layer->visible.bases = layer->bases;
    layer->visible.background = OST_BACKGROUND;
    memcpy(layer->visible.light, layer->light.face, sizeof layer->light.face);
    return OST_OK;
}

static ost_status room_over(ost_frame *frame, ost_error *err)
{
    if (frame->ghost.colour || planes_init(&frame->ghost, frame->width, frame->height))
        return OST_OK;
    planes_free(&frame->ghost);
    return no_memory(frame, err);
}

ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err)
{
    ost_status status = OST_OK;
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d things to draw; 1 to %d are supported", count, OST_FRAME_LAYERS);
    for (int i = 0; i < count && status == OST_OK; i++)
        status = prepare(frame, &things[i], i, things[0].surface->geometry.spacing.x, err);
    if (status != OST_OK)
        return status;
    frame->layers = count;
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
        /* One thread alone makes a block's list when the first band draws it: those of hidden blocks are never made. */
        for (int l = 0; l < count && frame->threads > 1; l++) {
            ost_frame_layer *layer = &frame->layer[l];
#pragma omp for schedule(dynamic, 4)
            for (int32_t i = 0; i < layer->count; i++)
                choose_points(frame, layer, &layer->blocks[i]);
        }
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++)
            draw_band(frame, i);
    }
    return OST_OK;
}

ost_status ost_frame_draw_ghost(ost_frame *frame, const ost_frame_thing *thing, unsigned share, ost_pm spacing, ost_error *err)
{
    enum { NUMBER = OST_FRAME_LAYERS - 1 };
    ost_frame_layer *layer = &frame->layer[NUMBER];
    ost_status status = room_over(frame, err);
    if (status == OST_OK)
        status = prepare(frame, thing, NUMBER, spacing, err);
    if (status != OST_OK)
        return status;
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
#pragma omp for schedule(dynamic, 4)
        for (int32_t i = 0; i < (frame->threads > 1 ? layer->count : 0); i++)
            choose_points(frame, layer, &layer->blocks[i]);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++) {
            ost_planes planes = frame->ghost;
            const band at = band_of(frame, i, &planes);
            draw_layer(frame, layer, &at, &planes);
        }
#pragma omp for schedule(static, 16)
        for (int y = 0; y < frame->height; y++)
            merge_ghost(frame, layer, share, y);
    }
    return OST_OK;
}

ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err)
{
    const ost_frame_thing bone = {.surface = surface, .eye = *eye, .paint = OST_PAINT_BONE};
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
