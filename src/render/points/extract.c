/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A block and what lies about it, as words of 64 voxels:
 *
 *    bit   0 .. 15    16 .. 47     48 .. 63          rows y, z from -1 to 32
 *        block at x-1   its own   block at x+1
 *
 * A face of voxel x is to the air where its bit is set and the neighbour's is
 * not: one shift or the next row, and a mask, for 32 voxels at a time.
 * How they look comes after (dress.h).
 */
#include "render/points/extract.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "core/conditions.h"

enum { SIDE = OST_BLOCK, REACH = 1, WIDE = SIDE + 2 * REACH, OWN = 16 };

typedef struct around {
    uint64_t row[WIDE][WIDE]; /* [z + REACH][y + REACH] */
} around;

static void gather(const ost_surface *s, const ost_surface_block *b, around *out)
{
    static const uint32_t nothing[OST_BLOCK_ROWS];
    const uint32_t *near[3][3][3]; /* z, y, x */
    for (int i = 0; i < 27; i++) {
        const ost_surface_block *n = ost_surface_block_at(s, b->at[0] + i % 3 - 1, b->at[1] + i / 3 % 3 - 1, b->at[2] + i / 9 - 1);
        near[i / 9][i / 3 % 3][i % 3] = n ? n->occupancy : nothing;
    }
    for (int z = -REACH; z < SIDE + REACH; z++)
        for (int y = -REACH; y < SIDE + REACH; y++) {
            const uint32_t *const *n = near[(z >= 0) + (z >= SIDE)][(y >= 0) + (y >= SIDE)];
            const int row = (y & (SIDE - 1)) + SIDE * (z & (SIDE - 1));
            out->row[z + REACH][y + REACH] = n[0][row] >> (SIDE - OWN) | (uint64_t)n[1][row] << OWN | (uint64_t)n[2][row] << (OWN + SIDE);
        }
}

/* Voxels of row (y, z) whose faces are to the air, a word a face; returns those with any. */
static inline uint32_t faces_of_row(const around *a, int y, int z, uint32_t face[6])
{
    const int j = y + REACH, k = z + REACH;
    const uint64_t row = a->row[k][j];
    const uint32_t own = (uint32_t)(row >> OWN);
    const uint32_t behind[6] = {
        (uint32_t)(row >> (OWN - 1)),           (uint32_t)(row >> (OWN + 1)),           (uint32_t)(a->row[k][j - 1] >> OWN),
        (uint32_t)(a->row[k][j + 1] >> OWN), (uint32_t)(a->row[k - 1][j] >> OWN), (uint32_t)(a->row[k + 1][j] >> OWN),
    };
    uint32_t any = 0;
    for (int f = 0; f < 6; f++)
        any |= face[f] = own & ~behind[f];
    return any;
}

static bool make_room(ost_surface_block *b, uint32_t count)
{
    if (count <= b->room)
        return true;
    const uint32_t room = count + count / 4;
    uint32_t *points = realloc(b->points, room * sizeof *points);
    if (points)
        b->points = points;
    uint32_t *looks = realloc(b->looks, room * sizeof *looks);
    if (looks)
        b->looks = looks;
    if (points && looks)
        b->room = room;
    return points && looks;
}

/* What a renderer has a copy of is known by it, wherever a surface lies in memory. */
static _Atomic uint64_t versions;

ost_status ost_surface_list(const ost_surface *surface, ost_surface_block *block, ost_error *err)
{
    around a;
    uint32_t face[6], any[OST_BLOCK_ROWS], count = 0;
    gather(surface, block, &a);
    for (int row = 0; row < OST_BLOCK_ROWS; row++) {
        any[row] = faces_of_row(&a, row % SIDE, row / SIDE, face);
        count += (uint32_t)__builtin_popcount(any[row]);
    }
    if (!make_room(block, count))
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %u surface voxels", (unsigned)count);
    uint32_t n = 0;
    for (uint32_t row = 0; row < OST_BLOCK_ROWS; row++) {
        if (!any[row])
            continue;
        faces_of_row(&a, (int)(row % SIDE), (int)(row / SIDE), face);
        for (uint32_t left = any[row]; left; left &= left - 1, n++) {
            const int x = __builtin_ctz(left);
            uint32_t mask = 0;
            for (int f = 0; f < 6; f++)
                mask |= (face[f] >> x & 1) << f;
            block->points[n] = (uint32_t)x | row << 5 | mask << OST_FACES_SHIFT;
        }
    }
    block->count = count;
    block->version = 1 + atomic_fetch_add(&versions, 1);
    return OST_OK;
}
