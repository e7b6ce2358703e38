/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/remove/block_base.h"

#include <assert.h>
#include <stdlib.h>

#include "core/conditions.h"
#include "core/divider.h"
#include "core/int128.h"

/*
 * Returns 2^16 (q + r / divisor) for 0 <= r < divisor, rounded down with an error below 2. With s, d and I as in
 * core/divider.h, r >> s has at most 62 bits, d has 62 bits (divisor > 2^59 * 10^6 > 2^78) and I = floor(2^124 / (d +
 * 1)) < 2^63.  (r >> s) I <= (r / 2^s) * 2^124 * 2^s / divisor, so the result is never too large. The last rounding
 * loses less than 1, and each of the roundings of r, d and I loses less than 2^-44.
 */
static int64_t scaled(const ost_divider *by, int64_t q, ost_i128 r)
{
    const int64_t part = (int64_t)((ost_i128)(int64_t)(r >> (by->shift - 46)) * by->inverse >> 108);
    return q * (1 << 16) + part;
}

/*
 * Fills the table of bone axis b and tool axis a. `start` is the exact coordinate of the first block. From one
 * block to the next, the coordinate increases by 16 times the map's column[b][a] (ost_map), which is added as a
 * quotient and a remainder: 16 column = (16 step) divisor + 16 e with e = column - step divisor, |e| <= divisor / 2.
 */
static void fill(ost_block_bases *bases, const ost_divider *by, int b, int a, ost_i128 start)
{
    const ost_i128 d = by->divisor;
    ost_i128 r;
    int64_t q = ost_floor_by(by, start, &r), step_q = (int64_t)OST_MAP_BLOCK * bases->map->step[b][a];
    ost_i128 step_r = OST_MAP_BLOCK * (ost_i128_of(bases->map->column[b][a]) - bases->map->step[b][a] * d);
    for (; step_r < 0; step_q--)
        step_r += d;
    for (; step_r >= d; step_q++)
        step_r -= d;
    for (int32_t i = 0; i < bases->count[b]; i++) {
        bases->part[b][3 * i + a] = scaled(by, q, r);
        q += step_q;
        r += step_r;
        if (r >= d) {
            r -= d;
            q++;
        }
    }
}

ost_status ost_block_bases_reserve(ost_block_bases *bases, const int32_t count[3], ost_error *err)
{
    for (int b = 0; b < 3; b++) {
        const size_t needed = 3 * (size_t)count[b];
        if (needed <= bases->capacity[b])
            continue;
        int64_t *part = realloc(bases->part[b], needed * sizeof *part);
        if (!part)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the bases of %d blocks", (int)count[b]);
        bases->part[b] = part;
        bases->capacity[b] = needed;
    }
    return OST_OK;
}

void ost_block_bases_make(ost_block_bases *bases, const ost_map *map, const int32_t lo[3], const int32_t hi[3])
{
    bases->map = map;
    for (int b = 0; b < 3; b++) {
        bases->lo[b] = lo[b];
        bases->count[b] = hi[b] - lo[b];
        assert(3 * (size_t)bases->count[b] <= bases->capacity[b]);
    }
    const ost_divider by = ost_divider_of(ost_i128_of(map->divisor));
    for (int a = 0; a < 3; a++) {
        ost_i128 first = ost_i128_of(map->origin[a]);
        for (int b = 0; b < 3; b++)
            first += (ost_i128)OST_MAP_BLOCK * lo[b] * ost_i128_of(map->column[b][a]);
        for (int b = 0; b < 3; b++)
            fill(bases, &by, b, a, b == 0 ? first : 0);
    }
}

/*
 * Returns the range of bases at which a block can have a voxel in the tool's grid.
 *
 * A voxel of a block has u = base + i step[0] + j step[1] + k step[2] with 0 <= i, j, k <= 15. On each axis, let
 * `below` be the sum of 15 |step| over the negative steps, and `above` the sum over the positive ones. Then
 * base - below <= u <= base + above. If this range does not overlap [0, dims 2^20), no voxel of the block is inside the
 * tool's grid. below + above is 15 times a sum of three |step|, and therefore less than 2^29 (AR-MAP-5), so `from` and
 * from + width fit in int32.
 */
ost_block_reach ost_block_reach_of(const int32_t step[3][3], const int32_t dims[3])
{
    ost_block_reach r;
    for (int a = 0; a < 3; a++) {
        int32_t below = 0, above = 0;
        for (int b = 0; b < 3; b++) {
            below += step[b][a] < 0 ? -(OST_MAP_BLOCK - 1) * step[b][a] : 0;
            above += step[b][a] > 0 ? (OST_MAP_BLOCK - 1) * step[b][a] : 0;
        }
        r.from[a] = -above;
        r.width[a] = ((uint32_t)dims[a] << OST_MAP_FRACTION) + (uint32_t)below + (uint32_t)above;
    }
    return r;
}

void ost_block_bases_free(ost_block_bases *bases)
{
    for (int b = 0; b < 3; b++)
        free(bases->part[b]);
    *bases = (ost_block_bases){0};
}
