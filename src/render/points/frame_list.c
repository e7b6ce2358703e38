/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the lists of a layer: for each block, the voxels with a face toward the eye. Also manages the memory of
   the lists, and finds their differences from the previous frame. */
#include "core/conditions.h"
#include "render/points/frame_parts.h"

#include <stdlib.h>
#include <string.h>

static void lists_free(ost_visible *v)
{
    free(v->seen);
    free(v->only);
    free(v->extent);
}

void ost_layer_free(ost_frame_layer *layer)
{
    lists_free(&layer->visible);
    free(layer->visible.begin);
    free(layer->blocks);
    free(layer->bases);
    free(layer->list);
    ost_cells_free(&layer->cells);
}

static ost_status out_of_memory(const ost_frame_layer *layer, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for drawing %llu surface voxels",
                    (unsigned long long)layer->surface->points);
}

static ost_status make_slots(ost_frame_layer *layer, ost_error *err)
{
    const int32_t used = layer->surface->used;
    if (used <= layer->slot_capacity)
        return OST_OK;
    const size_t capacity = (size_t)used + (size_t)used / 4;
    ost_frame_list *list = realloc(layer->list, capacity * sizeof *list);
    layer->list = list ? list : layer->list;
    uint32_t *begin = realloc(layer->visible.begin, capacity * sizeof *begin);
    layer->visible.begin = begin ? begin : layer->visible.begin;
    free(layer->blocks);
    free(layer->bases);
    layer->blocks = malloc(capacity * sizeof *layer->blocks);
    layer->bases = malloc(capacity * 4 * sizeof *layer->bases);
    if (!list || !begin || !layer->blocks || !layer->bases) {
        layer->slot_capacity = layer->slots = 0;
        return out_of_memory(layer, err);
    }
    layer->slot_capacity = (int32_t)capacity;
    return OST_OK;
}

/*
 * Returns the capacity to reserve for `count` entries: one eighth more for growth, rounded up to a multiple of
 * OST_LANES.
 */
static uint32_t padded(uint32_t count)
{
    return (count + count / 8 + OST_LANES - 1) / OST_LANES * OST_LANES;
}

/* Reallocates the memory of all lists. Their contents are lost. */
static ost_status make_lists(ost_frame_layer *layer, ost_error *err)
{
    const ost_surface *s = layer->surface;
    ost_visible *v = &layer->visible;
    size_t need = 0;
    for (int32_t i = 0; i < s->used; i++)
        need += padded(s->slot[i]->count);
    lists_free(v);
    layer->visible_capacity = need + need / 4 + OST_LANES;
    v->seen = malloc(layer->visible_capacity * sizeof *v->seen);
    v->only = malloc(layer->visible_capacity * sizeof *v->only);
    v->extent = malloc((layer->visible_capacity / OST_LANES + 1) * sizeof(_Atomic uint64_t));
    layer->visible_used = 0;
    layer->slots = 0;
    if (v->seen && v->only && v->extent)
        return OST_OK;
    lists_free(v);
    v->seen = NULL;
    v->only = NULL;
    v->extent = NULL;
    layer->visible_capacity = 0;
    return out_of_memory(layer, err);
}

/* Assigns memory to the lists of all blocks. Returns false if the capacity is not sufficient. */
static bool place_lists(ost_frame_layer *layer)
{
    const ost_surface *s = layer->surface;
    for (int32_t i = 0; i < s->used; i++) {
        ost_frame_list *l = &layer->list[i];
        const uint32_t capacity = padded(s->slot[i]->count);
        if (i >= layer->slots)
            *l = (ost_frame_list){0};
        if (s->slot[i]->count <= l->capacity)
            continue;
        if (layer->visible_used + capacity > layer->visible_capacity)
            return false;
        l->visible_first = (uint32_t)layer->visible_used;
        l->capacity = capacity;
        layer->visible_used += capacity;
    }
    return true;
}

ost_status ost_layer_reserve(ost_frame_layer *layer, ost_error *err)
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

void ost_layer_make_list(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *with)
{
    const ost_surface_block *block = layer->surface->slot[slot];
    ost_frame_list *list = &layer->list[slot];
    const ost_visible *v = &layer->visible;
    const uint32_t begin = list->visible_first;
    uint8_t turned[3][OST_BLOCK];
    for (int a = 0; a < 3; a++)
        ost_blocks_turned(layer->bases[4 * slot + a], a, turned[a]);
    ost_chosen *chosen = &with->chosen;
    list->count = frame->kernels.facing(block, (uint32_t)slot, turned, chosen);
    frame->tint(&layer->light, chosen->shade, list->count, with->tint);
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

/* The set of the parts of a block whose appearance has changed. A part is a cube of PART voxels per side. */
enum { PART = 4, PARTS = OST_BLOCK / PART };

typedef struct parts {
    uint64_t bit[PARTS]; /* bit x + 8 * y of element z represents the part (x, y, z) */
} parts;

static void differs(parts *p, uint32_t id)
{
    p->bit[(id >> 10 & 31) / PART] |= UINT64_C(1) << ((id & 31) / PART + PARTS * ((id >> 5 & 31) / PART));
}

/* Recomputes the list of a block, and marks the parts in which it differs from the old list. Both lists are sorted. */
static void choose_again(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *old,
                         parts *out)
{
    const ost_frame_list *list = &layer->list[slot];
    const ost_visible *v = &layer->visible;
    const uint32_t was = list->count, from = v->begin[slot];
    memcpy(old->seen, v->seen + from, was * sizeof *old->seen);
    memcpy(old->only, v->only + from, was * sizeof *old->only);
    ost_layer_make_list(frame, layer, slot, old);
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

/*
 * Sets frame->part to the cells that changed blocks may cover, before or after the change. A hidden block without a
 * list adds no cells: the voxels that hid it either still hide it, or have changed and thus add their own cells.
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
        choose_again(frame, layer, slot, frame->bench[ost_frame_thread()].lists, &p);
#pragma omp critical(ost_frame_part)
        add_parts(&frame->part, layer, slot, &p);
    }
}

void ost_layer_drop_lists(const ost_frame_layer *layer)
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

void ost_layer_make_lists(const ost_frame *frame, const ost_frame_layer *layer)
{
#pragma omp for schedule(dynamic, 4)
    for (int32_t i = 0; i < layer->count; i++)
        if (!layer->list[layer->blocks[i].slot].listed)
            ost_layer_make_list(frame, layer, layer->blocks[i].slot, frame->bench[ost_frame_thread()].lists);
}

const ost_planes *ost_frame_choose_part(ost_frame *frame)
{
    const ost_frame_layer *first = &frame->layer[0];
    const bool still = first->same && frame->stored.colour;
    if (still && frame->is_stored && !frame->planes.key) {
        find_part(frame, first);
        ost_cells_clear(&frame->stale);
        ost_cells_join(&frame->stale, &frame->part);
        ost_cells_join(&frame->stale, &frame->over);
    } else {
        ost_cells_fill(&frame->part);
        ost_cells_fill(&frame->stale);
        ost_layer_drop_lists(first);
    }
    frame->is_stored = still;
    remember_sight(first);
    ost_cells_clear(&frame->over);
    for (int i = 1; i < frame->layers; i++)
        ost_layer_drop_lists(&frame->layer[i]);
    return still ? &frame->stored : &frame->drawn;
}
