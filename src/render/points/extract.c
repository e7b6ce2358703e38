/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/extract.h"

#include <string.h>

#include "core/conditions.h"

enum { SIDE = OST_BLOCK, LAST = SIDE - 1, REACH = OST_LOOK_REACH };

static const uint32_t nothing[OST_BLOCK_ROWS];

typedef const uint32_t *nearby[3][3][3]; /* z, y, x: words of 27 blocks */

static bool look_around(const ost_surface *s, const ost_surface_block *b, ost_words_of *which, nearby near)
{
    bool any = false;
    for (int i = 0; i < 27; i++) {
        const ost_surface_block *n = ost_surface_block_at(s, b->at[0] + i % 3 - 1, b->at[1] + i / 3 % 3 - 1, b->at[2] + i / 9 - 1);
        const uint32_t *words = n ? which(n) : NULL;
        any |= words != NULL;
        near[i / 9][i / 3 % 3][i % 3] = words ? words : nothing;
    }
    return any;
}

bool ost_surface_rim(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, ost_rim *out)
{
    nearby near;
    if (!look_around(surface, block, which, near))
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

bool ost_surface_rows(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, const ost_row_kernels *kernels, ost_rows *out)
{
    nearby near;
    if (!look_around(surface, block, which, near))
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
