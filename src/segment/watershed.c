/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements a watershed in two steps, each in descending order of the height:
 *
 *   height
 *     |    A                    1. Basins grow from their peaks (A, B, C).  Where two basins
 *     |   / \      B               meet, the one with the lower peak is joined to the other one
 *     |  /   \ C  / \              if this peak is less than `depth` above the pass: C to A.
 *     | /     V \/   \          2. The remaining peaks (A, B) are markers, from which the
 *     |/       pass   \            pieces are flooded.
 *
 * Step 2 visits the voxels of a plateau in the order of a queue, so a plateau between two markers is divided in the
 * middle. Step 1 alone would assign the complete plateau to the basin that comes first.
 */
#include "core/conditions.h"

#include "segment/watershed.h"

#include <stdlib.h>

enum { LEVELS = SEGMENT_DISTANCE_MAX + 1 };
#define NONE UINT32_MAX

typedef struct basin {
    uint32_t parent; /* basin to which this basin was joined; this basin's own number if it was not joined */
    uint32_t peak;   /* first voxel of the basin, which is also its highest */
} basin;

typedef struct basins {
    basin *items; /* owned */
    uint32_t count, capacity;
} basins;

static uint32_t root(basin *items, uint32_t b)
{
    while (items[b].parent != b) {
        items[b].parent = items[items[b].parent].parent; /* halves the length of the path to the root */
        b = items[b].parent;
    }
    return b;
}

static ost_status add(basins *all, uint32_t peak, ost_error *err)
{
    if (all->count == all->capacity) {
        const uint64_t wanted = all->capacity ? 2 * (uint64_t)all->capacity : 4096;
        basin *grown = wanted < NONE ? realloc(all->items, (size_t)wanted * sizeof *grown) : NULL;
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %llu maxima of the distance",
                            (unsigned long long)wanted);
        all->items = grown;
        all->capacity = (uint32_t)wanted;
    }
    all->items[all->count] = (basin){.parent = all->count, .peak = peak};
    all->count++;
    return OST_OK;
}

/* Sorts the voxels by descending height. Voxels of equal height remain in ascending order. */
static void sort(const segment_sparse *sparse, const uint32_t *height, uint32_t *count, uint32_t *order)
{
    for (uint32_t l = 0; l < LEVELS; l++)
        count[l] = 0;
    for (uint32_t i = 0; i < sparse->count; i++)
        count[height[i]]++;
    uint32_t first = 0;
    for (uint32_t l = LEVELS; l-- > 0;) {
        const uint32_t here = count[l];
        count[l] = first;
        first += here;
    }
    for (uint32_t i = 0; i < sparse->count; i++)
        order[count[height[i]]++] = i;
}

/*
 * Performs step 1. Basins are numbered in the order of their peaks. Of two basins, the one with the lower number is
 * therefore the higher one or, if both are equally high, the one whose peak comes first in the grid.
 */
static ost_status find_basins(const segment_sparse *sparse, const uint32_t *height, uint32_t depth,
                              const uint32_t *order, uint32_t *basin_of, basins *all, ost_error *err)
{
    for (uint32_t i = 0; i < sparse->count; i++)
        basin_of[i] = NONE;
    for (uint32_t k = 0; k < sparse->count; k++) {
        const uint32_t i = order[k];
        uint32_t near[SEGMENT_NEIGHBOURS], highest = NONE;
        const int count = segment_neighbours(sparse, i, near);
        for (int n = 0; n < count; n++) {
            near[n] = basin_of[near[n]] == NONE ? NONE : root(all->items, basin_of[near[n]]);
            highest = near[n] < highest ? near[n] : highest;
        }
        if (highest == NONE) {
            const ost_status status = add(all, i, err);
            if (status != OST_OK)
                return status;
            basin_of[i] = all->count - 1;
            continue;
        }
        basin_of[i] = highest;
        for (int n = 0; n < count; n++)
            if (near[n] != NONE && height[all->items[near[n]].peak] - height[i] < depth)
                all->items[near[n]].parent = highest;
    }
    return OST_OK;
}

/*
 * One queue for each level of height. A queue contains voxels that have been reached, but whose neighbours have not
 * been visited yet.
 */
typedef struct flood {
    uint32_t *head, *tail; /* owned; LEVELS elements each; head[l] is NONE if the queue of level l is empty */
    uint32_t *next;        /* borrowed; one element per voxel */
} flood;

static void append(flood *f, uint32_t level, uint32_t i)
{
    f->next[i] = NONE;
    if (f->head[level] == NONE)
        f->head[level] = i;
    else
        f->next[f->tail[level]] = i;
    f->tail[level] = i;
}

/*
 * Performs step 2. A voxel above the current level is appended to the queue of the current level, so that the level
 * never rises.
 */
static void flood_pieces(const segment_sparse *sparse, const uint32_t *height, const basins *all, flood *f,
                         uint32_t *piece, uint32_t *pieces)
{
    *pieces = 0;
    for (uint32_t i = 0; i < sparse->count; i++)
        piece[i] = NONE;
    for (uint32_t l = 0; l < LEVELS; l++)
        f->head[l] = NONE;
    for (uint32_t b = 0; b < all->count; b++) {
        const uint32_t peak = all->items[b].peak;
        if (all->items[b].parent != b)
            continue;
        piece[peak] = (*pieces)++;
        append(f, height[peak], peak);
    }
    for (uint32_t l = LEVELS; l-- > 0;)
        while (f->head[l] != NONE) {
            const uint32_t i = f->head[l];
            uint32_t near[SEGMENT_NEIGHBOURS];
            const int count = segment_neighbours(sparse, i, near);
            for (int n = 0; n < count; n++)
                if (piece[near[n]] == NONE) {
                    piece[near[n]] = piece[i];
                    append(f, height[near[n]] < l ? height[near[n]] : l, near[n]);
                }
            f->head[l] = f->next[i];
        }
}

ost_status ost_segment_watershed(const segment_sparse *sparse, const uint32_t *height, uint32_t depth, uint32_t *piece,
                                 uint32_t *pieces, ost_error *err)
{
    basins all = {.items = NULL};
    uint32_t *order = malloc(((size_t)sparse->count + 1) * sizeof *order);
    flood f = {malloc(LEVELS * sizeof *f.head), malloc(LEVELS * sizeof *f.tail), order};
    ost_status status = OST_OK;
    if (!order || !f.head || !f.tail)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the separation of %lu voxels",
                          (unsigned long)sparse->count);
    if (status == OST_OK) {
        sort(sparse, height, f.head, order);
        status = find_basins(sparse, height, depth, order, piece, &all, err);
    }
    if (status == OST_OK)
        flood_pieces(sparse, height, &all, &f, piece, pieces);
    free(all.items);
    free(order);
    free(f.head);
    free(f.tail);
    return status;
}
