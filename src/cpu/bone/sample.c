/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the densities of single voxels. The functions are called in each tick, so they neither allocate memory nor
   block. */
#include "core/conditions.h"
#include "cpu/bone/bone.h"
#include "cpu/cpu.h"

void ost_sample_scalar(const cpu_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities)
{
    const ost_dims d = bone->base.geometry.dims;
    const int n = bone->base.chunk_size, shift = n == 16 ? 4 : n == 32 ? 5 : 6;
    for (size_t i = 0; i < count; i++) {
        int32_t x = at[0][i], y = at[1][i], z = at[2][i];
        densities[i] = 0;
        if (x < 0 || y < 0 || z < 0 || x >= d.x || y >= d.y || z >= d.z)
            continue;
        const int64_t row = (y >> shift) + (int64_t)bone->chunk_dims.y * (z >> shift);
        const cpu_chunk *chunk = &bone->chunks[(x >> shift) + bone->chunk_dims.x * row];
        if (!chunk->occupancy)
            continue;
        /* The occupancy bit is read first, because it is more likely to be in the cache: a cache line contains 16 times
           as many occupancy bits as densities. */
        x &= n - 1;
        y &= n - 1;
        z &= n - 1;
        const size_t brick = (size_t)ost_brick_number(x >> 2, y >> 2, z >> 2),
                     in = (size_t)((x & 3) + (y & 3) * 4 + (z & 3) * 16);
        if (chunk->occupancy[brick] >> in & 1)
            densities[i] = chunk->density[brick * OST_BRICK_VOXELS + in];
    }
}

ost_status ost_cpu_bone_sample(const ost_bone *base, size_t count, const int32_t *const at[3], int16_t *densities,
                               ost_error *err)
{
    (void)err;
    ((const cpu_backend *)base->backend)->kernels.sample((const cpu_bone *)base, count, at, densities);
    return OST_OK;
}
