/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/extract.h"

#include <string.h>

#include "core/conditions.h"

enum { SIDE = OST_BLOCK, LAST = SIDE - 1, REACH = OST_SHADING_REACH };

static const uint32_t nothing[OST_BLOCK_ROWS];

ost_surface_block *ost_surface_block_at(const ost_surface *s, int32_t x, int32_t y, int32_t z)
{
    if (x < 0 || y < 0 || z < 0 || x >= s->blocks[0] || y >= s->blocks[1] || z >= s->blocks[2])
        return NULL;
    const int32_t slot = s->slot_of[x + (size_t)s->blocks[0] * ((size_t)y + (size_t)s->blocks[1] * (size_t)z)];
    return slot < 0 ? NULL : s->slot[slot];
}

typedef const uint32_t *nearby[3][3][3]; /* words of the block and its 26 neighbours, indexed by [z][y][x] */

static bool find_neighbours(const ost_surface *s, const ost_surface_block *b, ost_words_of *which, nearby near)
{
    bool any = false;
    for (int i = 0; i < 27; i++) {
        const ost_surface_block *n = ost_surface_block_at(s, b->at[0] + i % 3 - 1, b->at[1] + i / 3 % 3 - 1,
                                                          b->at[2] + i / 9 - 1);
        const uint32_t *words = n ? which(n) : NULL;
        any |= words != NULL;
        near[i / 9][i / 3 % 3][i % 3] = words ? words : nothing;
    }
    return any;
}

bool ost_surface_rim(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, ost_rim *out)
{
    nearby near;
    if (!find_neighbours(surface, block, which, near))
        return false;
    out->left = near[1][1][0];
    out->right = near[1][1][2];
    for (int z = -1; z <= SIDE; z++) {
        const uint32_t *const(*slice)[3] = near[(z >= 0) + (z >= SIDE)];
        const int row = SIDE * (z & LAST);
        uint32_t *to = out->row[z + 1];
        memcpy(to + 1, slice[1][1] + row, SIDE * sizeof *to);
        to[0] = slice[0][1][row + LAST];
        to[SIDE + 1] = slice[2][1][row];
    }
    return true;
}

bool ost_surface_rows(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which,
                      const ost_row_kernels *kernels, ost_rows *out)
{
    nearby near;
    if (!find_neighbours(surface, block, which, near))
        return false;
    for (int k = 0; k < OST_SEEN; k++) {
        const int z = k - REACH, row = SIDE * (z & LAST), tail = row + SIDE - REACH;
        const uint32_t *const(*n)[3] = near[(z >= 0) + (z >= SIDE)];
        uint64_t *to = out->row[k];
        kernels->join(n[0][0] + tail, n[0][1] + tail, n[0][2] + tail, to, REACH);
        kernels->join(n[1][0] + row, n[1][1] + row, n[1][2] + row, to + REACH, SIDE);
        kernels->join(n[2][0] + row, n[2][1] + row, n[2][2] + row, to + REACH + SIDE, REACH);
    }
    return true;
}

/* ----------------------------------------------------------------- changes */

/* Adds the changes in one of the 27 blocks. Sets the bit of each row in which this block has a changed voxel that is at
   most `reach` voxels away from the middle block. at[] is the position of the block relative to the middle block, -1 to
   1 on each axis. */
static void add_changes(const uint32_t *words, const int at[3], int reach, uint64_t rows[OST_SEEN])
{
    const uint32_t all = UINT32_MAX, seen = at[0] < 0 ? all << (SIDE - reach) : at[0] > 0 ? all >> (SIDE - reach) : all;
    int first[3], last[3];
    for (int a = 1; a < 3; a++) {
        first[a] = at[a] < 0 ? SIDE - reach : 0;
        last[a] = at[a] > 0 ? reach - 1 : LAST;
    }
    for (int z = first[2]; z <= last[2]; z++) {
        uint64_t any = 0;
        for (int y = first[1]; y <= last[1]; y++)
            any |= (uint64_t)((words[y + SIDE * z] & seen) != 0) << (y + SIDE * at[1] + REACH);
        rows[z + SIDE * at[2] + REACH] |= any;
    }
}

static const uint32_t *changed_of(const ost_surface_block *b) { return b->changed; }

bool ost_surface_changes(const ost_surface *surface, const ost_surface_block *block, int reach, uint64_t rows[OST_SEEN])
{
    nearby near;
    if (!find_neighbours(surface, block, changed_of, near))
        return false;
    memset(rows, 0, OST_SEEN * sizeof *rows);
    for (int i = 0; i < 27; i++)
        if (near[i / 9][i / 3 % 3][i % 3] != nothing)
            add_changes(near[i / 9][i / 3 % 3][i % 3], (const int[]){i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}, reach, rows);
    /* `done` is the number of rows by which the changes are spread so far; a step of at most 2 done + 1 rows leaves no
       gap. */
    for (int done = 0, step; done < reach; done += step) {
        uint64_t was[OST_SEEN];
        step = reach - done < 2 * done + 1 ? reach - done : 2 * done + 1;
        for (int z = 0; z < OST_SEEN; z++)
            was[z] = rows[z] | rows[z] << step | rows[z] >> step;
        for (int z = 0; z < OST_SEEN; z++)
            rows[z] = was[z] | (z >= step ? was[z - step] : 0) | (z + step < OST_SEEN ? was[z + step] : 0);
    }
    return true;
}
