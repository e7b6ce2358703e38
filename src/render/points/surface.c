/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/extract.h"

#include "render/points/block_words.h"
#include "render/points/clip.h"
#include "render/points/uncut.h"
#include "render/points/renew.h"
#include "render/points/smooth.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS = OST_BLOCK_ROWS, SIDE = OST_BLOCK };

ost_status ost_surface_init(ost_surface *surface, const ost_geometry *geometry, ost_error *err)
{
    memset(surface, 0, sizeof *surface);
    ost_status status = ost_geometry_check(geometry, "a surface's grid", err);
    if (status != OST_OK)
        return status;
    const ost_pm3 *s = &geometry->spacing;
    if (s->x != s->y || s->x != s->z)
        return ost_fail(err, OST_ERR_RANGE, "a surface needs cubic voxels, not %lld x %lld x %lld pm", (long long)s->x,
                        (long long)s->y, (long long)s->z);
    surface->geometry = *geometry;
    surface->blocks[0] = (geometry->dims.x + SIDE - 1) / SIDE;
    surface->blocks[1] = (geometry->dims.y + SIDE - 1) / SIDE;
    surface->blocks[2] = (geometry->dims.z + SIDE - 1) / SIDE;
    const size_t all = (size_t)surface->blocks[0] * (size_t)surface->blocks[1] * (size_t)surface->blocks[2];
    surface->slot_of = malloc(all * sizeof *surface->slot_of);
    if (!surface->slot_of)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface of %zu blocks", all);
    memset(surface->slot_of, 0xff, all * sizeof *surface->slot_of);
    return OST_OK;
}

void ost_surface_free(ost_surface *surface)
{
    for (int32_t i = 0; i < surface->used; i++) {
        ost_surface_block *b = surface->slot[i];
        free(b->points);
        free(b->shades);
        free(b->changed);
        free(b->before);
        free(b->fresh);
        free(b->recent);
        free(b->depth);
        free(b);
    }
    free(surface->scratch);
    free(surface->renewed);
    free(surface->slot);
    free(surface->slot_of);
    memset(surface, 0, sizeof *surface);
}

static int32_t *slot_at(const ost_surface *s, int32_t x, int32_t y, int32_t z)
{
    return s->slot_of + (x + (size_t)s->blocks[0] * ((size_t)y + (size_t)s->blocks[1] * (size_t)z));
}

/* Returns true if the block has no shown voxel in the box from `lo` to `hi` (inclusive). The box is relative to the
   block and may extend beyond it. */
static bool block_is_empty(const ost_surface_block *b, const int32_t lo[3], const int32_t hi[3])
{
    int32_t from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = lo[a] > 0 ? lo[a] : 0;
        to[a] = hi[a] < SIDE - 1 ? hi[a] : SIDE - 1;
    }
    const uint32_t mask = UINT32_MAX << from[0] & UINT32_MAX >> (SIDE - 1 - to[0]);
    for (int32_t z = from[2]; z <= to[2]; z++)
        for (int32_t y = from[1]; y <= to[1]; y++)
            if (b->occupancy[y + SIDE * z] & mask)
                return false;
    return true;
}

bool ost_surface_is_empty(const ost_surface *surface, const int32_t lo[3], const int32_t hi[3])
{
    int32_t from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = lo[a] > 0 ? lo[a] / SIDE : 0;
        to[a] = hi[a] < SIDE * surface->blocks[a] ? hi[a] / SIDE : surface->blocks[a] - 1;
        if (hi[a] < 0)
            return true;
    }
    for (int32_t z = from[2]; z <= to[2]; z++)
        for (int32_t y = from[1]; y <= to[1]; y++)
            for (int32_t x = from[0]; x <= to[0]; x++) {
                const ost_surface_block *b = ost_surface_block_at(surface, x, y, z);
                const int32_t at[3] = {SIDE * x, SIDE * y, SIDE * z};
                const int32_t l[3] = {lo[0] - at[0], lo[1] - at[1], lo[2] - at[2]},
                              h[3] = {hi[0] - at[0], hi[1] - at[1], hi[2] - at[2]};
                if (b && !block_is_empty(b, l, h))
                    return false;
            }
    return true;
}

static ost_status remember(const ost_surface *s, ost_surface_block *b, ost_error *err)
{
    free(b->depth);
    free(b->before);
    b->depth = NULL;
    b->before = NULL;
    b->dirty = b->remade = b->unmeasured = true;
    if (!s->reference)
        return OST_OK;
    b->before = malloc(ROWS * sizeof *b->before);
    if (!b->before)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a block of the uncut bone");
    ost_block_words(&s->reference->volume, b->at, s->reference->threshold, b->before);
    return OST_OK;
}

static ost_status new_block(ost_surface *s, const int32_t at[3], ost_surface_block **out, ost_error *err)
{
    if (s->used == OST_BLOCKS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "the bone has more than %d blocks of 32^3 voxels to draw", OST_BLOCKS_MAX);
    if (s->used == s->capacity) {
        const int32_t capacity = s->capacity ? 2 * s->capacity : 64;
        ost_surface_block **slot = realloc(s->slot, (size_t)capacity * sizeof(ost_surface_block *));
        if (!slot)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d blocks of a surface", (int)capacity);
        s->slot = slot;
        s->capacity = capacity;
    }
    ost_surface_block *b = calloc(1, sizeof *b);
    if (!b)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a block of a surface");
    memcpy(b->at, at, sizeof b->at);
    b->unlisted = true;
    *slot_at(s, at[0], at[1], at[2]) = s->used;
    s->slot[s->used++] = b;
    *out = b;
    return remember(s, b, err);
}

/* Computes the bounding box of all differing bits, in coordinates within the block. Returns false if no bits differ. */
static bool changed_box(const uint32_t *was, const uint32_t *is, int lo[3], int hi[3])
{
    uint32_t x = 0, y = 0, z = 0;
    for (int row = 0; row < ROWS; row++) {
        const uint32_t differs = was[row] ^ is[row];
        x |= differs;
        y |= (uint32_t)(differs != 0) << (row % SIDE);
        z |= (uint32_t)(differs != 0) << (row / SIDE);
    }
    const uint32_t axis[3] = {x, y, z};
    for (int a = 0; a < 3 && x; a++) {
        lo[a] = __builtin_ctz(axis[a]);
        hi[a] = SIDE - 1 - __builtin_clz(axis[a]);
    }
    return x != 0;
}

/* The kinds of data of a block that depend on voxels of other blocks. */
typedef enum sees { SEES_SHADES, SEES_POINTS, SEES_CELLS, SEES_UNCUT } sees;

/* Marks the blocks within `reach` voxels of the changed box, including the changed block itself. */
static void mark(const ost_surface *s, const int32_t at[3], const int lo[3], const int hi[3], int reach, sees what)
{
    int from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = lo[a] < reach ? -1 : 0;
        to[a] = hi[a] >= SIDE - reach ? 1 : 0;
    }
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++) {
                ost_surface_block *b = ost_surface_block_at(s, at[0] + x, at[1] + y, at[2] + z);
                if (!b)
                    continue;
                b->dirty = true;
                b->unlisted |= what == SEES_POINTS;
                b->unmeasured |= what == SEES_CELLS || what == SEES_UNCUT;
                b->remade |= what == SEES_UNCUT;
            }
}

static ost_status note_changed(ost_surface_block *b, const uint32_t occupancy[ROWS], ost_error *err)
{
    if (!b->changed)
        b->changed = calloc(ROWS, sizeof *b->changed);
    if (!b->changed)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of changes");
    for (int row = 0; row < ROWS; row++)
        b->changed[row] |= b->occupied[row] ^ occupancy[row];
    return OST_OK;
}

static ost_status note_fresh(ost_surface *s, ost_surface_block *b, const uint32_t occupancy[ROWS], ost_error *err)
{
    uint32_t any = 0;
    for (int row = 0; row < ROWS; row++)
        any |= b->occupied[row] & ~occupancy[row];
    if (!any)
        return OST_OK;
    if (!b->fresh)
        b->fresh = calloc(ROWS, sizeof *b->fresh);
    if (!b->fresh)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of removed voxels");
    for (int row = 0; row < ROWS; row++)
        b->fresh[row] |= b->occupied[row] & ~occupancy[row];
    s->any_fresh = true;
    return OST_OK;
}

ost_status ost_surface_set(ost_surface *surface, const int32_t at[3], const uint32_t occupancy[OST_BLOCK_ROWS],
                           ost_error *err)
{
    static const uint32_t nothing[ROWS];
    ost_surface_block *b = ost_surface_block_at(surface, at[0], at[1], at[2]);
    int lo[3], hi[3];
    if (!changed_box(b ? b->occupied : nothing, occupancy, lo, hi))
        return OST_OK;
    ost_status status = OST_OK;
    if (!b) {
        static const int first[3] = {0, 0, 0}, last[3] = {SIDE - 1, SIDE - 1, SIDE - 1};
        status = new_block(surface, at, &b, err);
        /* the shades of the neighbouring blocks may depend on the uncut bone in the new block */
        mark(surface, at, first, last, 1, SEES_UNCUT);
    }
    if (status == OST_OK)
        status = note_changed(b, occupancy, err);
    if (status == OST_OK && surface->shows_contact)
        status = note_fresh(surface, b, occupancy, err);
    if (status != OST_OK)
        return status;
    memcpy(b->occupied, occupancy, sizeof b->occupied);
    if (surface->clipped)
        ost_clip_words(&surface->clip, at, b->occupied, b->occupancy);
    else
        memcpy(b->occupancy, occupancy, sizeof b->occupancy);
    mark(surface, at, lo, hi, 1, SEES_POINTS);
    mark(surface, at, lo, hi, surface->reference ? OST_NEAR_REACH : 0, SEES_CELLS);
    mark(surface, at, lo, hi, surface->reference ? OST_SHADING_REACH : OST_WIDE_REACH, SEES_SHADES);
    return OST_OK;
}

/* ------------------------------------------------------ visibility, shades */

void ost_surface_clip(ost_surface *surface, const ost_clip *clip)
{
    surface->clipped = clip != NULL;
    if (clip)
        surface->clip = *clip;
    for (int32_t i = 0; i < surface->used; i++) {
        ost_surface_block *b = surface->slot[i];
        uint32_t shown[ROWS];
        int lo[3], hi[3];
        if (clip)
            ost_clip_words(clip, b->at, b->occupied, shown);
        else
            memcpy(shown, b->occupied, sizeof shown);
        if (!changed_box(b->occupancy, shown, lo, hi))
            continue;
        memcpy(b->occupancy, shown, sizeof shown);
        mark(surface, b->at, lo, hi, 1, SEES_POINTS);
    }
}

ost_status ost_surface_set_uncut(ost_surface *surface, ost_uncut *reference, ost_error *err)
{
    ost_status status = OST_OK;
    if (reference && !ost_geometry_equal(&surface->geometry, &reference->volume.geometry))
        return ost_fail(err, OST_ERR_USAGE, "the uncut bone has another grid");
    surface->reference = reference;
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++)
        status = remember(surface, surface->slot[i], err);
    return status;
}

void ost_surface_set_colouring(ost_surface *surface, int colouring)
{
    for (int32_t i = 0; i < surface->used && colouring != surface->colouring; i++)
        surface->slot[i]->dirty = surface->slot[i]->remade = true;
    surface->colouring = colouring;
}

void ost_surface_age(ost_surface *surface)
{
    static const uint32_t nothing[ROWS];
    if (!surface->any_fresh && !surface->any_recent)
        return;
    for (int32_t i = 0; i < surface->used; i++) {
        ost_surface_block *b = surface->slot[i];
        int lo[3], hi[3];
        /* Fresh and recent voxels are shaded alike. Shades therefore change only where the two sets differ. */
        if (b->recent && changed_box(b->fresh ? b->fresh : nothing, b->recent, lo, hi))
            mark(surface, b->at, lo, hi, 1, SEES_SHADES);
        free(b->recent);
        b->recent = b->fresh;
        b->fresh = NULL;
    }
    surface->any_recent = surface->any_fresh;
    surface->any_fresh = false;
}

/* Sets a chunk of 16^3 voxels, an eighth of a block. Each of its words contains two rows. */
static ost_status set_eighth(ost_surface *surface, const int32_t at[3], const uint32_t *words, ost_error *err)
{
    enum { HALF = SIDE / 2 };
    const int32_t block[3] = {at[0] / 2, at[1] / 2, at[2] / 2};
    const int shift = HALF * (at[0] % 2), y0 = HALF * (at[1] % 2), z0 = HALF * (at[2] % 2);
    const ost_surface_block *b = ost_surface_block_at(surface, block[0], block[1], block[2]);
    uint32_t occupancy[ROWS] = {0};
    if (b)
        memcpy(occupancy, b->occupied, sizeof occupancy);
    for (int z = 0; z < HALF; z++)
        for (int y = 0; y < HALF; y++) {
            uint32_t *row = &occupancy[y0 + y + SIDE * (z0 + z)];
            const int v = HALF * (y + HALF * z);
            *row = (*row & ~(UINT32_C(0xffff) << shift)) | (words[v / 32] >> (v % 32) & 0xffff) << shift;
        }
    return ost_surface_set(surface, block, occupancy, err);
}

ost_status ost_surface_set_chunk(ost_surface *surface, const int32_t at[3], int n, const uint32_t *words,
                                 ost_error *err)
{
    if (n == SIDE)
        return ost_surface_set(surface, at, words, err);
    if (n < SIDE)
        return set_eighth(surface, at, words, err);
    ost_status status = OST_OK;
    for (int part = 0; part < 8 && status == OST_OK; part++) {
        const int p[3] = {part & 1, part >> 1 & 1, part >> 2};
        const int32_t block[3] = {2 * at[0] + p[0], 2 * at[1] + p[1], 2 * at[2] + p[2]};
        uint32_t occupancy[ROWS];
        for (int row = 0; row < ROWS; row++) {
            const int y = SIDE * p[1] + row % SIDE, z = SIDE * p[2] + row / SIDE;
            occupancy[row] = words[(n * (y + n * z)) / 32 + p[0]];
        }
        if (block[0] < surface->blocks[0] && block[1] < surface->blocks[1] && block[2] < surface->blocks[2])
            status = ost_surface_set(surface, block, occupancy, err);
    }
    return status;
}

ost_status ost_surface_update(ost_surface *surface, ost_error *err)
{
    const size_t capacity = (size_t)surface->used + 1;
    int32_t *renewed = realloc(surface->renewed, capacity * sizeof *renewed);
    if (!renewed)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu blocks of a surface", capacity);
    surface->renewed = renewed;
    surface->renewals = 0;
    surface->points = 0;
    ost_status status = ost_surface_measure_all(surface, err);
    for (int32_t i = 0; i < surface->used; i++) {
        if (surface->slot[i]->dirty && status == OST_OK)
            status = ost_surface_renew(surface, i, err);
        surface->points += surface->slot[i]->count;
    }
    /* cleared only after all blocks are updated, because the update of a block reads these sets of its neighbours */
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++) {
        free(surface->slot[i]->changed);
        surface->slot[i]->changed = NULL;
    }
    return status;
}

/* ------------------------------------------------------------ from volumes */

ost_status ost_surface_set_volume(ost_surface *surface, const ost_volume *volume, int32_t threshold, ost_error *err)
{
    if (!ost_geometry_equal(&surface->geometry, &volume->geometry))
        return ost_fail(err, OST_ERR_USAGE, "the volume's grid is not the surface's");
    uint32_t occupancy[ROWS];
    int32_t at[3];
    for (at[2] = 0; at[2] < surface->blocks[2]; at[2]++)
        for (at[1] = 0; at[1] < surface->blocks[1]; at[1]++)
            for (at[0] = 0; at[0] < surface->blocks[0]; at[0]++) {
                ost_block_words(volume, at, threshold, occupancy);
                ost_status status = ost_surface_set(surface, at, occupancy, err);
                if (status != OST_OK)
                    return status;
            }
    return OST_OK;
}
