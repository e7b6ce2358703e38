/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/frame_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for a frame of %d x %d pixels", f->width, f->height);
}

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

ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads,
                          ost_error *err)
{
    memset(frame, 0, sizeof *frame);
    if (width < 1 || width > OST_FRAME_MAX || height < 1 || height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; expected 1 to %d a side", width, height,
                        OST_FRAME_MAX);
    frame->width = width;
    frame->height = height;
    frame->style = style;
    frame->band = OST_BAND;
    frame->kernels = ost_splat_kernels_of(isa);
    frame->tint = ost_light_tint_for(isa);
    frame->rows = ost_triangle_rows_for(isa);
#ifdef _OPENMP
    frame->threads = threads ? threads : omp_get_num_procs();
#else
    (void)threads;
    frame->threads = 1;
#endif
    const bool planes = planes_init(&frame->planes, width, height);
    frame->drawn = frame->planes;
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

ost_status ost_frame_store_keys(ost_frame *frame, ost_error *err)
{
    return frame->planes.key || keys_init(&frame->planes, frame->height) ? OST_OK : no_memory(frame, err);
}

ost_status ost_frame_store(ost_frame *frame, ost_error *err)
{
    if (frame->stored.colour || planes_init(&frame->stored, frame->width, frame->height))
        return OST_OK;
    planes_free(&frame->stored);
    return no_memory(frame, err);
}

ost_status ost_frame_antialias(ost_frame *frame, ost_isa isa, ost_error *err)
{
    /* one extra element, because antialiasing reads one pixel beyond the end */
    const size_t count = (size_t)frame->planes.stride * (size_t)frame->height + 1;
    uint32_t *colour = plane_alloc(count, sizeof *colour);
    if (!colour || !ost_antialias_init(&frame->antialias, frame->width, frame->height, isa) ||
        !ost_cells_init(&frame->smoothed, frame->width, frame->height)) {
        free(colour);
        ost_antialias_free(&frame->antialias);
        return no_memory(frame, err);
    }
    memset(colour, 0, count * sizeof *colour);
    frame->drawn.colour = colour;
    return OST_OK;
}

/*
 * Smooths the edges of the drawn colours in the cells of frame->smoothed, and writes the result to the frame's colours.
 */
static void smooth_edges(ost_frame *frame)
{
    const uint32_t *from = frame->drawn.colour;
    uint32_t *to = frame->planes.colour;
    const int stride = frame->planes.stride;
    const bool faces = frame->style == OST_STYLE_FACES;
#pragma omp parallel num_threads(frame->threads)
    {
#pragma omp for schedule(dynamic, 4)
        for (int row = 0; row < frame->smoothed.rows; row++)
            if (faces)
                ost_antialias_none(&frame->antialias, &frame->smoothed, row);
            else
                ost_antialias_edges(&frame->antialias, from, stride, &frame->smoothed, row);
#pragma omp for schedule(dynamic, 4)
        for (int row = 0; row < frame->smoothed.rows; row++)
            ost_antialias_smooth(&frame->antialias, from, to, stride, &frame->smoothed, row);
    }
}

void ost_frame_overwritten(ost_frame *frame)
{
    ost_cells_fill(&frame->over);
    if (!frame->antialias.below)
        return;
    ost_cells_fill(&frame->smoothed);
    smooth_edges(frame);
}

void ost_frame_changed(const ost_frame *frame, const ost_cells *cells)
{
    ost_cells_join(cells, &frame->stale);
    ost_cells_join(cells, &frame->over);
    if (frame->smoothed.bit)
        ost_cells_join(cells, &frame->smoothed);
}

ost_sheet ost_frame_sheet(const ost_frame *frame)
{
    return (ost_sheet){frame->planes.colour, frame->planes.stride, frame->width, frame->height, &frame->over};
}

void ost_frame_free(ost_frame *frame)
{
    if (frame->antialias.below)
        free(frame->drawn.colour);
    ost_antialias_free(&frame->antialias);
    ost_cells_free(&frame->smoothed);
    planes_free(&frame->planes);
    planes_free(&frame->ghost);
    planes_free(&frame->stored);
    benches_free(frame);
    ost_cells_free(&frame->part);
    ost_cells_free(&frame->stale);
    ost_cells_free(&frame->over);
    free(frame->blank);
    free(frame->directions);
    for (int i = 0; i < OST_FRAME_LAYERS; i++) {
        ost_layer_free(&frame->layer[i]);
        ost_triangles_free(&frame->smooth[i]);
    }
    memset(frame, 0, sizeof *frame);
}

static void find_cells(ost_frame_layer *layer)
{
    ost_cells_clear(&layer->cells);
    for (int32_t i = 0; i < layer->count; i++) {
        const ost_extent *e = &layer->blocks[i].pixels;
        ost_cells_add(&layer->cells, e->x0, e->x1, e->y0, e->y1);
    }
}

/*
 * Returns true if a ray may enter a voxel through a face that is not exposed. This is possible only if the ray begins
 * inside a voxel, or passes through a voxel that the near plane excludes. Measured along the forward axis, the centre
 * of an excluded voxel is at most near + sqrt(3) from the eye, and its corners at most near + 2 sqrt(3). Measured along
 * a ray, these distances are at most c times as great, where 1 / c is the cosine of the angle between the forward axis
 * and the ray to a corner of the frame.
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
    return !ost_surface_is_empty(surface, lo, hi);
}

/* Computes the light of a layer. Returns true if the light is the same as in the previous frame. */
static bool make_light(const ost_frame *frame, ost_frame_layer *layer, const ost_frame_thing *thing)
{
    uint32_t colour[OST_PAINTS], face[8];
    ost_light *l = &layer->light;
    const uint8_t gloss = l->gloss;
    const ost_style style = l->style;
    memcpy(colour, l->colour, sizeof colour);
    memcpy(face, l->face, sizeof face);
    ost_light_make(l, frame->directions, &thing->eye, frame->style, thing->paint, thing->palette);
    return gloss == l->gloss && style == l->style && memcmp(colour, l->colour, sizeof colour) == 0 &&
           memcmp(face, l->face, sizeof face) == 0;
}

static ost_status prepare(ost_frame *frame, const ost_frame_thing *thing, int number, ost_pm spacing, ost_error *err)
{
    ost_frame_layer *layer = &frame->layer[number];
    ost_status status = ost_blocks_check(thing->surface, &thing->eye, err);
    if (status != OST_OK)
        return status;
    const bool within = is_within(thing->surface, &thing->eye), lit = make_light(frame, layer, thing);
    layer->same = frame->stored.colour && lit && within == layer->within && layer->surface == thing->surface &&
                  memcmp(&layer->eye.eye, &thing->eye, sizeof thing->eye) == 0;
    layer->surface = thing->surface;
    layer->within = within;
    layer->eye = ost_splat_prepare(&thing->eye);
    status = ost_layer_reserve(layer, err);
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

/* Prepares the objects: each becomes a layer of voxels or, if it has a smooth mesh, a set of triangles. */
static ost_status prepare_all(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err)
{
    const ost_pm spacing = things[0].surface->geometry.spacing.x;
    ost_status status = OST_OK;
    frame->layers = frame->smooth_count = 0;
    for (int i = 0; i < count && status == OST_OK; i++) {
        const ost_frame_thing *thing = &things[i];
        if (thing->mesh)
            status = ost_triangles_project(&frame->smooth[frame->smooth_count++], thing->mesh, &thing->eye,
                                           thing->paint,
                                           (float)((double)thing->surface->geometry.spacing.x / (double)spacing), err);
        else
            status = prepare(frame, thing, frame->layers++, spacing, err);
    }
    return status;
}

static ost_status reserve_over(ost_frame *frame, ost_error *err)
{
    if (frame->ghost.colour || planes_init(&frame->ghost, frame->width, frame->height))
        return OST_OK;
    planes_free(&frame->ghost);
    return no_memory(frame, err);
}

ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err)
{
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d objects to draw; expected 1 to %d", count, OST_FRAME_LAYERS);
    ost_status status = prepare_all(frame, things, count, err);
    if (status != OST_OK) {
        for (int i = 0; i < frame->layers; i++)
            /* the surfaces may have changed without being drawn, so the next frame must not reuse anything */
            frame->layer[i].surface = NULL;
        return status;
    }
    const ost_planes *base = ost_frame_choose_part(frame);
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
        /* With one thread, no lists are computed here. The list of a block is computed when the block is first drawn,
           so hidden blocks need no list. */
        for (int l = 0; l < frame->layers && frame->threads > 1; l++)
            ost_layer_make_lists(frame, &frame->layer[l]);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++)
            ost_frame_draw_band(frame, i, base);
    }
    if (frame->antialias.below) {
        /* smooths three kinds of cells and their surroundings: those drawn in this frame, those restored in this frame,
         * and those drawn over in the previous frame */
        ost_cells_clear(&frame->smoothed);
        ost_cells_join(&frame->smoothed, &frame->stale);
        ost_cells_join(&frame->smoothed, &frame->over);
        ost_cells_grow(&frame->smoothed, OST_ANTIALIAS_CELLS_ACROSS, OST_ANTIALIAS_CELLS_DOWN);
        smooth_edges(frame);
    }
    return OST_OK;
}

ost_status ost_frame_draw_ghost(ost_frame *frame, const ost_frame_thing *thing, unsigned share, ost_pm spacing,
                                ost_error *err)
{
    enum { NUMBER = OST_FRAME_LAYERS - 1 };
    ost_frame_layer *layer = &frame->layer[NUMBER];
    ost_status status = reserve_over(frame, err);
    if (status == OST_OK)
        status = prepare(frame, thing, NUMBER, spacing, err);
    if (status != OST_OK) {
        layer->surface = NULL;
        return status;
    }
    ost_layer_drop_lists(layer);
    ost_cells_join(&frame->over, &layer->cells);
    const int bands = (frame->height + frame->band - 1) / frame->band;
#pragma omp parallel num_threads(frame->threads)
    {
        if (frame->threads > 1)
            ost_layer_make_lists(frame, layer);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < bands; i++)
            ost_frame_draw_ghost_band(frame, layer, i);
#pragma omp for schedule(static, 16)
        for (int y = 0; y < frame->height; y++)
            ost_frame_merge_ghost_row(frame, layer, share, y);
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
