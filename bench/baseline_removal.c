/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' removal of material in C. For every voxel of every chunk of the event, the position
 * in the tool's grid is computed with a float matrix. If the position is inside the grid and the
 * tool's voxel at this position is solid, the bone's voxel becomes 0. A loop over chunks replaces
 * the enqueued kernels of Alg. 2.10, and a loop over voxels replaces the work items of one kernel.
 */
#include "bench/baseline.h"

#if defined __AVX512BW__
#include <immintrin.h>
#endif

static void remove_from_chunk(const bench_thesis_event *e, int16_t *chunk, const int32_t corner[3])
{
    const int32_t n = e->chunk_size;
    for (int32_t z = 0; z < n; z++)
        for (int32_t y = 0; y < n; y++)
            for (int32_t x = 0; x < n; x++) {
                const float px = (float)(corner[0] + x), py = (float)(corner[1] + y), pz = (float)(corner[2] + z);
                const float tx = e->map[0][0] * px + e->map[0][1] * py + e->map[0][2] * pz + e->map[0][3];
                const float ty = e->map[1][0] * px + e->map[1][1] * py + e->map[1][2] * pz + e->map[1][3];
                const float tz = e->map[2][0] * px + e->map[2][1] * py + e->map[2][2] * pz + e->map[2][3];
                if (tx < 0 || ty < 0 || tz < 0)
                    continue;
                const int32_t ix = (int32_t)tx, iy = (int32_t)ty, iz = (int32_t)tz;
                if (ix >= e->dims[0] || iy >= e->dims[1] || iz >= e->dims[2])
                    continue;
                if (e->tool[ix + e->dims[0] * (iy + e->dims[1] * iz)] > 0)
                    chunk[x + n * (y + n * z)] = 0;
            }
}

void bench_thesis_remove(const bench_thesis_event *event, int threads)
{
    (void)threads;
#if defined _OPENMP
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (threads > 1)
#endif
    for (int c = 0; c < event->chunk_count; c++)
        remove_from_chunk(event, event->chunks[c], event->corners[c]);
}

void bench_store_rows(const bench_row_store *rows, size_t count)
{
    for (size_t r = 0; r < count; r++) {
#if defined __AVX512BW__
        _mm512_mask_storeu_epi16(rows[r].row, rows[r].hit, _mm512_setzero_si512());
#else
        for (int i = 0; i < 32; i++)
            rows[r].row[i] = rows[r].hit >> i & 1 ? 0 : rows[r].row[i];
#endif
    }
}
