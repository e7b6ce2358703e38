/* SPDX-License-Identifier: Apache-2.0 */
/* The scalar kernels of the bone: rows of voxels are converted into bricks, four voxels at a time. */
#include <string.h>

#include "core/conditions.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

ost_brick_sums ost_brick_row_scalar(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                    int16_t *density, uint64_t *occupancy)
{
    (void)stream;
    ost_brick_sums sums = {0, 0};
    for (size_t x = 0; x < bricks; x++) {
        const size_t at = (size_t)ost_brick_spread((int32_t)x);
        int16_t brick[OST_BRICK_VOXELS];
        for (int r = 0; r < 16; r++)
            memcpy(brick + 4 * r, rows[r] + 4 * x, 4 * sizeof *brick);
        uint64_t word = 0;
        for (int v = 0; v < OST_BRICK_VOXELS; v++) {
            word |= (uint64_t)(brick[v] >= threshold) << v;
            brick[v] = brick[v] >= threshold ? brick[v] : 0;
            sums.active += brick[v] != 0;
            sums.highest = brick[v] > sums.highest ? brick[v] : sums.highest;
        }
        memcpy(density + at * OST_BRICK_VOXELS, brick, sizeof brick);
        occupancy[at] = word;
    }
    return sums;
}

bool ost_any_active_scalar(const int16_t *base, const size_t *row, int count, int width, int16_t threshold)
{
    for (int r = 0; r < count; r++)
        for (int x = 0; x < width; x++)
            if (base[row[r] + (size_t)x] >= threshold)
                return true;
    return false;
}

void ost_drain_scalar(void)
{
}
