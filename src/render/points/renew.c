/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between two frames, a tool typically removes a few dozen voxels of one block. A shade depends only on voxels at most
 * OST_SHADING_REACH away, so the shades of most rows of points remain valid:
 *
 *   bits shown --faces--> rows whose list changed --------.
 *   bits that changed --> rows within reach --------------+--> stale rows --shade--> shades
 *   previous shades ------------------------ other rows --'                        '--> contact
 *
 * All shades of a row are computed together. The contact paint also changes with time, so it is applied to all points
 * in every update.
 */
#include "render/points/renew.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "render/points/shading.h"

enum { SIDE = OST_BLOCK, ROWS = OST_BLOCK_ROWS };

ost_status ost_surface_use(ost_surface *surface, ost_isa isa, ost_error *err)
{
    enum { LINE = 64, SIZE = (sizeof(ost_shading_scratch) + LINE - 1) / LINE * LINE };
    if (!surface->scratch)
        surface->scratch = aligned_alloc(LINE, SIZE);
    if (!surface->scratch)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the shading of a surface");
    memset(surface->scratch, 0, SIZE);
    surface->scratch->rows = ost_row_kernels_of(isa);
    surface->scratch->smooth = ost_smooth_kernels_of(isa);
    return OST_OK;
}

static ost_status make_scratch(ost_surface *s, ost_error *err)
{
    ost_isa isa;
    if (s->scratch)
        return OST_OK;
    ost_status status = ost_isa_choose(NULL, &isa, err);
    return status == OST_OK ? ost_surface_use(s, isa, err) : status;
}

static const uint32_t *shown_of(const ost_surface_block *b) { return b->occupancy; }

/* ------------------------------------------------------------------- stale */

static bool same_points(const ost_surface_block *b, const uint32_t *points, const ost_shading_scratch *k, int row)
{
    const uint32_t *was = b->points + b->begin[row], *is = points + k->faces.begin[row];
    for (int i = 0, count = k->faces.begin[row + 1] - k->faces.begin[row]; i < count; i++)
        if (was[i] != is[i])
            return false;
    return true;
}

/* Finds the rows whose points or shades may have changed. Returns false if there are none. */
static bool find_changed(const ost_surface *s, const ost_surface_block *b, const uint32_t *points,
                         ost_shading_scratch *k)
{
    const ost_faces *f = &k->faces;
    uint64_t changes[OST_SEEN];
    const bool changed = !b->remade &&
                         ost_surface_changes(s, b, s->reference ? OST_SHADING_REACH : OST_WIDE_REACH, changes);
    uint32_t any = 0;
    memset(k->stale, 0, sizeof k->stale);
    for (int row = 0; row < ROWS; row++) {
        const int z = row / SIDE, y = row % SIDE;
        if (!f->any[row])
            continue;
        bool stale = b->remade || f->begin[row + 1] - f->begin[row] != b->begin[row + 1] - b->begin[row];
        if (!stale)
            stale = (changed && changes[z + OST_SHADING_REACH] >> (y + OST_SHADING_REACH) & 1) ||
                    (b->unlisted && !same_points(b, points, k, row));
        k->stale[z] |= (uint32_t)stale << y;
        any |= stale;
    }
    return any != 0;
}

/* Copies the previous shades of the rows that are not stale. */
static void copy_shading(const ost_surface_block *b, ost_shading_scratch *k)
{
    const uint16_t *begin = k->faces.begin;
    for (int row = 0; row < ROWS; row++)
        if (!(k->stale[row / SIDE] >> row % SIDE & 1))
            for (uint32_t i = begin[row], was = b->begin[row]; i < begin[row + 1]; i++, was++)
                k->shades[i] = b->shades[was];
}

/* ----------------------------------------------------------------- contact */

static void mark_contact(ost_surface_block *b, const uint32_t *points, ost_shading_scratch *k)
{
    uint32_t any = 0;
    for (int row = 0; row < ROWS; row++)
        any |= k->contact[row];
    if (!any && !b->contact)
        return;
    for (uint32_t i = 0, count = k->faces.begin[ROWS]; i < count; i++) {
        const uint32_t hot = k->contact[points[i] >> 5 & (ROWS - 1)] >> (points[i] & (SIDE - 1)) & 1;
        k->shades[i] = (k->shades[i] & ~OST_SHADE_CONTACT) | (hot ? OST_SHADE_CONTACT : 0);
    }
    b->contact = any != 0;
}

/* ------------------------------------------------------------------- block */

static bool reserve_points(ost_surface_block *b, uint32_t count)
{
    if (count <= b->capacity)
        return true;
    const uint32_t capacity = count + count / 4;
    uint32_t *points = realloc(b->points, capacity * sizeof *points);
    if (points)
        b->points = points;
    uint32_t *shades = realloc(b->shades, capacity * sizeof *shades);
    if (shades)
        b->shades = shades;
    if (points && shades)
        b->capacity = capacity;
    return points && shades;
}

/* The most recent version number. A renderer identifies its copy of a list by the version of the list, because the
   address of a block may be reused by another surface. */
static _Atomic uint64_t versions;

static ost_status take(ost_surface *s, int32_t slot, const uint32_t *points, const ost_shading_scratch *k,
                       ost_error *err)
{
    ost_surface_block *b = s->slot[slot];
    const uint32_t count = k->faces.begin[ROWS];
    const size_t size = count * sizeof *points;
    const bool same = b->version && count == b->count && (count == 0 || memcmp(points, b->points, size) == 0);
    if (same && (count == 0 || memcmp(k->shades, b->shades, size) == 0))
        return OST_OK;
    if (!reserve_points(b, count))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %u surface voxels", (unsigned)count);
    if (points != b->points && count > 0)
        memcpy(b->points, points, size);
    if (count > 0)
        memcpy(b->shades, k->shades, size);
    memcpy(b->begin, k->faces.begin, sizeof b->begin);
    b->count = count;
    b->version = 1 + atomic_fetch_add(&versions, 1);
    if (!same)
        b->listed = b->version;
    s->renewed[s->renewals++] = slot;
    return OST_OK;
}

ost_status ost_surface_measure_all(ost_surface *surface, ost_error *err)
{
    ost_status status = make_scratch(surface, err);
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++)
        if (surface->slot[i]->unmeasured)
            ost_surface_measure(surface, surface->slot[i], surface->scratch);
    return status;
}

ost_status ost_surface_renew(ost_surface *surface, int32_t slot, ost_error *err)
{
    ost_surface_block *b = surface->slot[slot];
    ost_status status = OST_OK;
    ost_shading_scratch *k = surface->scratch;
    ost_surface_rim(surface, b, shown_of, &k->rim);
    k->rows.faces(&k->rim, &k->faces);
    if (b->unlisted)
        k->rows.points(&k->faces, k->points);
    const uint32_t *points = b->unlisted ? k->points : b->points;
    ost_surface_find_marked(surface, b, k);
    if (find_changed(surface, b, points, k))
        status = ost_surface_shade(surface, b, points, k, err);
    if (status == OST_OK) {
        /* copies the other rows last, because computing a stale row may overwrite words after this row */
        copy_shading(b, k);
        mark_contact(b, points, k);
        status = take(surface, slot, points, k, err);
    }
    if (status == OST_OK)
        b->dirty = b->remade = b->unlisted = false;
    return status;
}
