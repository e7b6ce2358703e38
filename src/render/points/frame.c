/* SPDX-License-Identifier: Apache-2.0 */
#include "core/bits_run.h"
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

/* A list that is made, and one as it was. */
typedef struct ost_frame_lists {
    ost_chosen chosen;
    uint32_t tint[OST_BLOCK_POINTS + OST_LANES];
    uint64_t seen[OST_BLOCK_POINTS];
    uint8_t only[OST_BLOCK_POINTS];
} ost_frame_lists;

static bool benches_init(ost_frame *f)
{
    const size_t tiles = (size_t)f->tiles_across * (size_t)(f->band / OST_TILE);
    f->bench = calloc((size_t)f->threads, sizeof *f->bench);
    for (int i = 0; f->bench && i < f->threads; i++) {
        ost_frame_bench *b = &f->bench[i];
        b->tiles = malloc(tiles * sizeof *b->tiles);
        b->lists = malloc(sizeof *b->lists);
        if (!planes_init(&b->over, f->width, f->band) || !keys_init(&b->over, f->band) || !b->tiles || !b->lists)
            return false;
    }
    return f->bench != NULL;
}

static void benches_free(ost_frame *f)
{
    for (int i = 0; f->bench && i < f->threads; i++) {
        planes_free(&f->bench[i].over);
        free(f->bench[i].tiles);
        free(f->bench[i].lists);
    }
    free(f->bench);
}

static bool cells_init(ost_frame *f)
{
    bool made = ost_cells_init(&f->part, f->width, f->height) && ost_cells_init(&f->stale, f->width, f->height) &&
                ost_cells_init(&f->over, f->width, f->height);
    for (int i = 0; i < OST_FRAME_LAYERS && made; i++)
        made = ost_cells_init(&f->layer[i].cells, f->width, f->height);
    return made;
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
    (void)threads;
    frame->threads = 1;
#endif
    const bool planes = planes_init(&frame->planes, width, height);
    frame->blank = malloc((size_t)frame->planes.stride * sizeof *frame->blank);
    frame->tiles_across = frame->planes.stride / OST_TILE;
    frame->directions = malloc(sizeof *frame->directions);
    if (frame->directions) {
        ost_directions_make(frame->directions);
        frame->directions->shade = ost_light_shade_for(isa);
    }
    if (!planes || !frame->directions || !frame->blank || !benches_init(frame) || !cells_init(frame)) {
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

ost_status ost_frame_keep(ost_frame *frame, ost_error *err)
{
    if (frame->kept.colour || planes_init(&frame->kept, frame->width, frame->height))
        return OST_OK;
    planes_free(&frame->kept);
    return no_memory(frame, err);
}

void ost_frame_overwritten(ost_frame *frame)
{
    ost_cells_fill(&frame->over);
}

ost_sheet ost_frame_sheet(const ost_frame *frame)
{
    return (ost_sheet){frame->planes.colour, frame->planes.stride, frame->width, frame->height, &frame->over};
}

static void lists_free(ost_visible *v)
{
    free(v->seen);
    free(v->only);
    free(v->extent);
}

static void layer_free(ost_frame_layer *layer)
{
    lists_free(&layer->visible);
    free(layer->visible.begin);
    free(layer->blocks);
    free(layer->bases);
    free(layer->list);
    ost_cells_free(&layer->cells);
}

void ost_frame_free(ost_frame *frame)
{
    planes_free(&frame->planes);
    planes_free(&frame->ghost);
    planes_free(&frame->kept);
    benches_free(frame);
    ost_cells_free(&frame->part);
    ost_cells_free(&frame->stale);
    ost_cells_free(&frame->over);
    free(frame->blank);
    free(frame->directions);
    for (int i = 0; i < OST_FRAME_LAYERS; i++)
        layer_free(&frame->layer[i]);
    memset(frame, 0, sizeof *frame);
}

static ost_status no_room(const ost_frame_layer *layer, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "no memory to draw %llu surface voxels", (unsigned long long)layer->surface->points);
}

static ost_status make_slots(ost_frame_layer *layer, ost_error *err)
{
    const int32_t used = layer->surface->used;
    if (used <= layer->slot_room)
        return OST_OK;
    const size_t room = (size_t)used + (size_t)used / 4;
    ost_frame_list *list = realloc(layer->list, room * sizeof *list);
    layer->list = list ? list : layer->list;
    uint32_t *begin = realloc(layer->visible.begin, room * sizeof *begin);
    layer->visible.begin = begin ? begin : layer->visible.begin;
    free(layer->blocks);
    free(layer->bases);
    layer->blocks = malloc(room * sizeof *layer->blocks);
    layer->bases = malloc(room * 4 * sizeof *layer->bases);
    if (!list || !begin || !layer->blocks || !layer->bases) {
        layer->slot_room = layer->slots = 0;
        return no_room(layer, err);
    }
    layer->slot_room = (int32_t)room;
    return OST_OK;
}

/* Of whole vectors, and some to grow. */
static uint32_t room_for(uint32_t count)
{
    return (count + count / 8 + OST_LANES - 1) / OST_LANES * OST_LANES;
}

/* All lists are lost. */
static ost_status make_lists(ost_frame_layer *layer, ost_error *err)
{
    const ost_surface *s = layer->surface;
    ost_visible *v = &layer->visible;
    size_t need = 0;
    for (int32_t i = 0; i < s->used; i++)
        need += room_for(s->slot[i]->count);
    lists_free(v);
    layer->visible_room = need + need / 4 + OST_LANES;
    v->seen = malloc(layer->visible_room * sizeof *v->seen);
    v->only = malloc(layer->visible_room * sizeof *v->only);
    v->extent = malloc((layer->visible_room / OST_LANES + 1) * sizeof(_Atomic uint64_t));
    layer->visible_used = 0;
    layer->slots = 0;
    if (v->seen && v->only && v->extent)
        return OST_OK;
    lists_free(v);
    v->seen = NULL;
    v->only = NULL;
    v->extent = NULL;
    layer->visible_room = 0;
    return no_room(layer, err);
}

/* A place for the list of every block. False when there is no more. */
static bool place_lists(ost_frame_layer *layer)
{
    const ost_surface *s = layer->surface;
    for (int32_t i = 0; i < s->used; i++) {
        ost_frame_list *l = &layer->list[i];
        const uint32_t room = room_for(s->slot[i]->count);
        if (i >= layer->slots)
            *l = (ost_frame_list){0};
        if (s->slot[i]->count <= l->room)
            continue;
        if (layer->visible_used + room > layer->visible_room)
            return false;
        l->place = (uint32_t)layer->visible_used;
        l->room = room;
        layer->visible_used += room;
    }
    return true;
}

/* layer->slots becomes the surface's; layer->same false when lists were lost, or are of other blocks. */
static ost_status make_room(ost_frame_layer *layer, ost_error *err)
{
    const ost_surface *s = layer->surface;
    ost_status status = make_slots(layer, err);
    layer->same = layer->same && layer->slots > 0 && layer->slots <= s->used;
    if (status == OST_OK && !place_lists(layer)) {
        layer->same = false;
        status = make_lists(layer, err);
        if (status == OST_OK)
            place_lists(layer);
    }
    if (status != OST_OK)
        return status;
    for (int32_t i = 0; i < s->used; i++) {
        ost_frame_list *l = &layer->list[i];
        layer->same = layer->same && (i >= layer->slots || memcmp(l->at, s->slot[i]->at, sizeof l->at) == 0);
        memcpy(l->at, s->slot[i]->at, sizeof l->at);
    }
    layer->slots = s->used;
    return OST_OK;
}

static void find_cells(ost_frame_layer *layer)
{
    ost_cells_clear(&layer->cells);
    for (int32_t i = 0; i < layer->count; i++) {
        const ost_extent *e = &layer->blocks[i].pixels;
        ost_cells_add(&layer->cells, e->x0, e->x1, e->y0, e->y1);
    }
}

static void choose_points(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *with)
{
    const ost_surface_block *block = layer->surface->slot[slot];
    ost_frame_list *list = &layer->list[slot];
    const ost_visible *v = &layer->visible;
    const uint32_t begin = list->place;
    uint8_t turned[3][OST_BLOCK];
    for (int a = 0; a < 3; a++)
        ost_blocks_turned(layer->bases[4 * slot + a], a, turned[a]);
    ost_chosen *chosen = &with->chosen;
    list->count = frame->kernels.facing(block, (uint32_t)slot, turned, chosen);
    frame->tint(&layer->light, chosen->look, list->count, with->tint);
    for (uint32_t i = 0; i < list->count; i++)
        v->seen[begin + i] = (uint64_t)with->tint[i] << 32 | chosen->id[i];
    if (layer->within)
        memset(v->only + begin, OST_SEVERAL, list->count);
    else
        memcpy(v->only + begin, chosen->only, list->count);
    for (uint32_t i = begin / OST_LANES; i < (begin + list->count + OST_LANES - 1) / OST_LANES; i++)
        atomic_store_explicit(&v->extent[i], OST_EXTENT_UNKNOWN, memory_order_relaxed);
    v->begin[slot] = begin;
    list->version = block->version;
    list->listed = true;
}

/* ------------------------------------------------------- what has changed */

/* Parts of a block that look different: cubes of 4 voxels on a side, a bit each. */
enum { PART = 4, PARTS = OST_BLOCK / PART };

typedef struct parts {
    uint64_t bit[PARTS]; /* of each z: x + 8 y */
} parts;

static void differs(parts *p, uint32_t id)
{
    p->bit[(id >> 10 & 31) / PART] |= UINT64_C(1) << ((id & 31) / PART + PARTS * ((id >> 5 & 31) / PART));
}

/* The list anew; where it has other voxels than before, or others to look at. Both are in order. */
static void choose_again(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *old, parts *out)
{
    const ost_frame_list *list = &layer->list[slot];
    const ost_visible *v = &layer->visible;
    const uint32_t was = list->count, from = v->begin[slot];
    memcpy(old->seen, v->seen + from, was * sizeof *old->seen);
    memcpy(old->only, v->only + from, was * sizeof *old->only);
    choose_points(frame, layer, slot, old);
    const uint64_t *seen = v->seen + v->begin[slot];
    const uint8_t *only = v->only + v->begin[slot];
    uint32_t i = 0, j = 0;
    while (i < was && j < list->count) {
        const uint32_t a = (uint32_t)old->seen[i], b = (uint32_t)seen[j];
        if (old->seen[i] != seen[j] || old->only[i] != only[j])
            differs(out, a < b ? a : b);
        i += a <= b;
        j += b <= a;
    }
    while (i < was)
        differs(out, (uint32_t)old->seen[i++]);
    while (j < list->count)
        differs(out, (uint32_t)seen[j++]);
}

static void add_parts(const ost_cells *cells, const ost_frame_layer *layer, int32_t slot, const parts *p)
{
    for (int z = 0; z < PARTS; z++)
        for (uint64_t left = p->bit[z]; left; left &= left - 1) {
            const int i = __builtin_ctzll(left), at[3] = {i % PARTS, i / PARTS, z};
            float middle[3];
            ost_extent e;
            for (int a = 0; a < 3; a++)
                middle[a] = layer->bases[4 * slot + a] + (float)(PART * at[a]) + 0.5f * (PART - 1);
            if (ost_blocks_pixels(&layer->eye, middle, PART, &e))
                ost_cells_add(cells, e.x0, e.x1, e.y0, e.y1);
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

/*
 * frame->part: what blocks that changed may cover, before or after.  Of a block
 * that was hidden, and so has no list, nothing was seen; what hid it is there
 * still, or was itself in the part.
 */
static void find_part(ost_frame *frame, const ost_frame_layer *layer)
{
    ost_cells_clear(&frame->part);
    for (int32_t i = 0; i < layer->count; i++) {
        const ost_frame_block *b = &layer->blocks[i];
        const ost_frame_list *list = &layer->list[b->slot];
        if (!list->there && !list->listed)
            ost_cells_add(&frame->part, b->pixels.x0, b->pixels.x1, b->pixels.y0, b->pixels.y1);
    }
#pragma omp parallel for num_threads(frame->threads) schedule(dynamic, 16)
    for (int32_t slot = 0; slot < layer->slots; slot++) {
        const ost_frame_list *list = &layer->list[slot];
        if (!list->listed || list->version == layer->surface->slot[slot]->version)
            continue;
        parts p = {0};
        choose_again(frame, layer, slot, frame->bench[thread_number()].lists, &p);
#pragma omp critical(ost_frame_part)
        add_parts(&frame->part, layer, slot, &p);
    }
}

static void forget_old(const ost_frame_layer *layer)
{
    for (int32_t slot = 0; slot < layer->slots; slot++) {
        ost_frame_list *list = &layer->list[slot];
        list->listed = list->listed && layer->same && list->version == layer->surface->slot[slot]->version;
    }
}

static void remember_sight(const ost_frame_layer *layer)
{
    for (int32_t slot = 0; slot < layer->slots; slot++)
        layer->list[slot].there = false;
    for (int32_t i = 0; i < layer->count; i++)
        layer->list[layer->blocks[i].slot].there = true;
}

/* ------------------------------------------------------------------ a band */

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
    const ost_extent *e = &b->pixels;
    const int top = e->y0 > at->y0 ? e->y0 : at->y0, end = e->y1 < at->y1 ? e->y1 : at->y1;
    return (tile_range){e->x0 / OST_TILE, (e->x1 + OST_TILE - 1) / OST_TILE, (top - at->y0) / OST_TILE, (end - at->y0 + OST_TILE - 1) / OST_TILE};
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
        for (int x = r.x0; x < r.x1; x++) {
            ost_frame_tile *t = &at->bench->tiles[y * f->tiles_across + x];
            t->stale = t->farthest > 0;
        }
}

/* A row of cells of a band. */
typedef struct cell_row {
    uint64_t bit[OST_CELL_WORDS];
    int words, y0, y1; /* y0 <= y < y1: its pixels */
} cell_row;

/* What two parts have in common, or of one what the other has not. */
static cell_row row_of(const ost_cells *a, const ost_cells *b, bool without, const band *at, int y)
{
    const uint64_t *x = ost_cells_row(a, y / OST_CELL_HEIGHT), *z = ost_cells_row(b, y / OST_CELL_HEIGHT);
    cell_row row = {.words = a->words, .y0 = y, .y1 = y + OST_CELL_HEIGHT < at->y1 ? y + OST_CELL_HEIGHT : at->y1};
    for (int i = 0; i < a->words; i++)
        row.bit[i] = x[i] & (without ? ~z[i] : z[i]);
    return row;
}

/* The next run of columns, in pixels; *to was 0 or where the last one ended. */
static bool next_run(const cell_row *row, int *from, int *to)
{
    int a, b = *to / OST_CELL_WIDTH;
    const bool found = ost_bits_run(row->bit, row->words, &a, &b);
    *from = a * OST_CELL_WIDTH;
    *to = b * OST_CELL_WIDTH;
    return found;
}

/* No voxel yet where it is to be drawn; everywhere else nothing may be seen. Returns what is to be drawn. */
static ost_extent begin(const ost_frame *f, const ost_frame_layer *layer, const ost_cells *part, const band *at, const ost_planes *planes)
{
    ost_extent e = {f->width, 0, at->y1, at->y0};
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&layer->cells, part, false, at, y);
        ost_frame_tile *tiles = &at->bench->tiles[(y - at->y0) / OST_TILE * f->tiles_across];
        for (int i = 0; i < f->tiles_across; i++)
            tiles[i] = (ost_frame_tile){0, false};
        for (int from, to = 0; next_run(&row, &from, &to);) {
            for (int j = row.y0; j < row.y1; j++)
                memset(ost_key_row(planes, j) + from, OST_EMPTY_BYTE, (size_t)(to - from) * sizeof *planes->key);
            for (int i = from / OST_TILE; i < to / OST_TILE; i++)
                tiles[i].farthest = OST_EMPTY_KEY;
            e.x0 = from < e.x0 ? from : e.x0;
            e.x1 = to > e.x1 ? to : e.x1;
            e.y0 = row.y0 < e.y0 ? row.y0 : e.y0;
            e.y1 = row.y1;
        }
    }
    return e;
}

/* What of a layer lies in `part`. */
static void draw_layer(const ost_frame *f, const ost_frame_layer *layer, const ost_cells *part, const band *at, const ost_planes *planes)
{
    const ost_extent e = begin(f, layer, part, at, planes);
    for (int32_t i = 0; i < layer->count && e.y0 < e.y1; i++) {
        const ost_frame_block *b = &layer->blocks[i];
        if (b->pixels.y0 >= e.y1 || b->pixels.y1 <= e.y0 || b->pixels.x0 >= e.x1 || b->pixels.x1 <= e.x0)
            continue;
        const tile_range r = tiles_of(b, at);
        if (hidden(f, at, planes, r, b->nearest))
            continue;
        if (!layer->list[b->slot].listed)
            choose_points(f, layer, b->slot, at->bench->lists);
        f->kernels.splat(&layer->eye, &layer->visible, (uint32_t)b->slot, layer->list[b->slot].count, planes, &e);
        drawn(f, at, r);
    }
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&layer->cells, part, false, at, y);
        for (int from, to = 0; next_run(&row, &from, &to);)
            for (int j = row.y0; j < row.y1; j++)
                f->kernels.resolve(&layer->eye, &layer->visible, planes, j, from, to);
    }
}

/* Background where the first layer cannot be. */
static void blank(const ost_frame *f, const band *at, const ost_planes *planes)
{
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&f->part, &f->layer[0].cells, true, at, y);
        for (int from, to = 0; next_run(&row, &from, &to);)
            for (int j = row.y0; j < row.y1; j++) {
                const size_t i = ost_row(planes, j) + (size_t)from, count = (size_t)(to - from);
                memset(planes->face + i, OST_NO_FACE, count);
                memcpy(planes->colour + i, f->blank, count * sizeof *planes->colour);
            }
    }
}

static void put_back(const ost_frame *f, const band *at)
{
    const ost_planes *to = &f->planes, *kept = &f->kept;
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&f->stale, &f->stale, false, at, y);
        for (int x, end = 0; next_run(&row, &x, &end);)
            for (int j = row.y0; j < row.y1; j++) {
                const size_t i = ost_row(to, j) + (size_t)x, count = (size_t)(end - x);
                memcpy(to->depth + i, kept->depth + i, count * sizeof *to->depth);
                memcpy(to->face + i, kept->face + i, count);
                memcpy(to->colour + i, kept->colour + i, count * sizeof *to->colour);
            }
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
    return ost_cells_has(&layer->cells, x, y) && f->ghost.face[ost_row(&f->ghost, y) + (size_t)x] != OST_NO_FACE;
}

/* What can be seen through, with its outline, in row y, columns from to to - 1: it leaves all but the colour as it was. */
static void merge_ghost(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y, int first, int end)
{
    enum { LINE = 100 };
    const ost_planes *to = &f->planes, *from = &f->ghost;
    for (int x = first; x < end && x < f->width; x++) {
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

static void merge_ghost_row(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y)
{
    const band at = {.y1 = f->height};
    const cell_row row = row_of(&layer->cells, &layer->cells, false, &at, y / OST_CELL_HEIGHT * OST_CELL_HEIGHT);
    for (int from, to = 0; next_run(&row, &from, &to);)
        merge_ghost(f, layer, ghost, y, from, to);
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

/* base: planes of the first layer alone, the frame's own unless they are kept. */
static void draw_band(const ost_frame *f, int number, const ost_planes *base)
{
    ost_planes planes = *base;
    planes.key = f->planes.key;
    const band at = band_of(f, number, &planes);
    ost_planes over = at.bench->over;
    over.top = over.key_top = at.y0;
    draw_layer(f, &f->layer[0], &f->part, &at, &planes);
    blank(f, &at, &planes);
    if (base != &f->planes)
        put_back(f, &at);
    for (int i = 1; i < f->layers; i++) {
        const ost_frame_layer *layer = &f->layer[i];
        if (layer->y0 >= at.y1 || layer->y1 <= at.y0)
            continue;
        draw_layer(f, layer, &layer->cells, &at, &over);
        for (int y = at.y0; y < at.y1; y += OST_CELL_HEIGHT) {
            const cell_row row = row_of(&layer->cells, &layer->cells, false, &at, y);
            for (int from, to = 0; next_run(&row, &from, &to);)
                for (int j = row.y0; j < row.y1; j++)
                    f->kernels.merge(&f->planes, &over, layer->scale, j, from, to, f->over.bit + (ptrdiff_t)(y / OST_CELL_HEIGHT) * f->over.words);
        }
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

/* Makes the light; whether it is as it was. */
static bool make_light(const ost_frame *frame, ost_frame_layer *layer, const ost_frame_thing *thing)
{
    uint32_t colour[OST_PAINTS], face[8];
    ost_light *l = &layer->light;
    const uint8_t gloss = l->gloss;
    const ost_style style = l->style;
    memcpy(colour, l->colour, sizeof colour);
    memcpy(face, l->face, sizeof face);
    ost_light_make(l, frame->directions, &thing->eye, frame->style, thing->paint, thing->palette);
    return gloss == l->gloss && style == l->style && memcmp(colour, l->colour, sizeof colour) == 0 && memcmp(face, l->face, sizeof face) == 0;
}

static ost_status prepare(ost_frame *frame, const ost_frame_thing *thing, int number, ost_pm spacing, ost_error *err)
{
    ost_frame_layer *layer = &frame->layer[number];
    ost_status status = ost_blocks_check(thing->surface, &thing->eye, err);
    if (status != OST_OK)
        return status;
    const bool within = is_within(thing->surface, &thing->eye), lit = make_light(frame, layer, thing);
    layer->same = frame->kept.colour && lit && within == layer->within && layer->surface == thing->surface &&
                  memcmp(&layer->eye.eye, &thing->eye, sizeof thing->eye) == 0;
    layer->surface = thing->surface;
    layer->within = within;
    layer->eye = ost_splat_prepare(&thing->eye);
    status = make_room(layer, err);
    if (status != OST_OK)
        return status;
    layer->scale = (float)((double)thing->surface->geometry.spacing.x / (double)spacing);
    ost_blocks_choose(layer->surface, &layer->eye, layer->blocks, layer->bases, &layer->count, &layer->y0, &layer->y1);
    find_cells(layer);
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

/* By all threads of a team. */
static void list_all(const ost_frame *frame, const ost_frame_layer *layer)
{
#pragma omp for schedule(dynamic, 4)
    for (int32_t i = 0; i < layer->count; i++)
        if (!layer->list[layer->blocks[i].slot].listed)
            choose_points(frame, layer, layer->blocks[i].slot, frame->bench[thread_number()].lists);
}

/*
 * What is drawn of the first layer, and into which planes.  Those that are kept
 * are drawn whole by the second of two frames that are alike, so that an eye
 * that moves pays nothing for them.  Numbers change with a list, so whoever
 * wants keys gets all of them anew.
 */
static const ost_planes *choose_part(ost_frame *frame)
{
    const ost_frame_layer *first = &frame->layer[0];
    const bool still = first->same && frame->kept.colour;
    if (still && frame->is_kept && !frame->planes.key) {
        find_part(frame, first);
        ost_cells_clear(&frame->stale);
        ost_cells_join(&frame->stale, &frame->part);
        ost_cells_join(&frame->stale, &frame->over);
    } else {
        ost_cells_fill(&frame->part);
        ost_cells_fill(&frame->stale);
        forget_old(first);
    }
    frame->is_kept = still;
    remember_sight(first);
    ost_cells_clear(&frame->over);
    for (int i = 1; i < frame->layers; i++)
        forget_old(&frame->layer[i]);
    return still ? &frame->kept : &frame->planes;
}

ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err)
{
    ost_status status = OST_OK;
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d things to draw; 1 to %d are supported", count, OST_FRAME_LAYERS);
    for (int i = 0; i < count && status == OST_OK; i++)
        status = prepare(frame, &things[i], i, things[0].surface->geometry.spacing.x, err);
    if (status != OST_OK) {
        for (int i = 0; i < count; i++)
            frame->layer[i].surface = NULL; /* no frame was drawn of what they have now */
        return status;
    }
    frame->layers = count;
    const ost_planes *base = choose_part(frame);
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
        /* One thread alone makes a block's list when the first band draws it: those of hidden blocks are never made. */
        for (int l = 0; l < count && frame->threads > 1; l++)
            list_all(frame, &frame->layer[l]);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++)
            draw_band(frame, i, base);
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
    if (status != OST_OK) {
        layer->surface = NULL;
        return status;
    }
    forget_old(layer);
    ost_cells_join(&frame->over, &layer->cells);
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
        if (frame->threads > 1)
            list_all(frame, layer);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++) {
            ost_planes planes = frame->ghost;
            const band at = band_of(frame, i, &planes);
            draw_layer(frame, layer, &layer->cells, &at, &planes);
        }
#pragma omp for schedule(static, 16)
        for (int y = 0; y < frame->height; y++)
            merge_ghost_row(frame, layer, share, y);
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
