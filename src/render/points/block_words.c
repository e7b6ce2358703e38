/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/block_words.h"

#include <string.h>

#include "core/conditions.h"

enum { SIDE = OST_BLOCK };

/*
 * Returns a word in which bit i is 1 if voxel i of the row is active. The row has `count` voxels, at most 32. A
 * multiplication combines eight bytes that are 0 or 1 into eight bits, because its partial products do not overlap.
 */
static uint32_t row_word(const int16_t *voxels, int count, int16_t threshold)
{
    uint8_t active[SIDE] = {0};
    uint32_t word = 0;
    if (count == SIDE) /* compilers vectorise a loop whose length is constant */
        for (int i = 0; i < SIDE; i++)
            active[i] = voxels[i] >= threshold;
    else
        for (int i = 0; i < count; i++)
            active[i] = voxels[i] >= threshold;
    for (int i = 0; i < SIDE; i += 8) {
        uint64_t eight;
        memcpy(&eight, active + i, sizeof eight);
        word |= (uint32_t)(eight * UINT64_C(0x0102040810204080) >> 56) << i;
    }
    return word;
}

void ost_block_words(const ost_volume *v, const int32_t at[3], int32_t threshold, uint32_t words[OST_BLOCK_ROWS])
{
    const ost_dims d = v->geometry.dims;
    const int x = at[0] * SIDE, count = d.x - x < SIDE ? d.x - x : SIDE;
    memset(words, 0, OST_BLOCK_ROWS * sizeof *words);
    for (int k = 0; k < SIDE && at[2] * SIDE + k < d.z; k++)
        for (int j = 0; j < SIDE && at[1] * SIDE + j < d.y; j++) {
            const size_t row = (size_t)(at[1] * SIDE + j) + (size_t)d.y * (size_t)(at[2] * SIDE + k);
            words[j + SIDE * k] = row_word(v->voxels + row * (size_t)d.x + x, count, (int16_t)threshold);
        }
}
