/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernel `sample`. The cases include every chunk size, grids that end within a chunk, chunks
 * without memory, voxels inside and outside the grid, and numbers of voxels near 16.
 */
#include "simd/check.h"

#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

typedef struct arguments {
    const cpu_bone *bone;
    size_t count;
    const int32_t *at[3];
    int16_t *densities;
} arguments;

static void call(check_fn *kernel, void *with)
{
    const arguments *a = with;
    ((ost_sample_fn *)kernel)(a->bone, a->count, a->at, a->densities);
}

static void test(check *c)
{
    static const char *const names[] = {"x", "y", "z"};
    const int n = check_chance(c, 30) ? 64 : check_chance(c, 4) ? 32 : 16;
    const int64_t sides[3] = {check_range(c, 1, 3), check_range(c, 1, n == 64 ? 1 : 2), check_range(c, 1, 2)};
    int32_t d[3];
    for (int a = 0; a < 3; a++)
        d[a] = (int32_t)(n * sides[a] - check_range(c, 0, n - 1));
    const size_t chunks = (size_t)(sides[0] * sides[1] * sides[2]), voxels = (size_t)n * (size_t)n * (size_t)n;
    cpu_chunk *table = check_input(c, "chunks", chunks, sizeof *table, sizeof(void *));
    for (size_t i = 0; i < chunks; i++) {
        table[i] = (cpu_chunk){0};
        if (check_chance(c, 3))
            continue;
        /* The densities are followed by the occupancy in the same allocation. */
        int16_t *density = check_input(c, "block", voxels + voxels / 16, sizeof *density, 64);
        uint64_t *occupancy = (uint64_t *)(void *)(density + voxels);
        const uint64_t some = check_chance(c, 4) ? ~UINT64_C(0) : (uint64_t)check_range(c, 0, INT64_MAX);
        for (size_t w = 0; w < voxels / 64; w++)
            occupancy[w] = some * (w + 1) ^ (uint64_t)w << 40;
        for (size_t v = 0; v < voxels; v++)
            density[v] = (int16_t)(v * 40503 + 1);
        table[i] = (cpu_chunk){.density = density, .occupancy = occupancy, .active = 1, .highest = INT16_MAX};
    }
    const cpu_bone bone = {.base = {.geometry.dims = {d[0], d[1], d[2]}, .chunk_size = n},
                           .chunk_dims = {(int32_t)sides[0], (int32_t)sides[1], (int32_t)sides[2]},
                           .count = (int64_t)chunks,
                           .chunks = table};
    const size_t count = c->number < 70 ? (size_t)c->number : (size_t)check_range(c, 0, 70);
    arguments a = {.bone = &bone, .count = count}, b;
    for (int k = 0; k < 3; k++) {
        int32_t *at = check_input(c, names[k], count, sizeof *at, sizeof *at);
        for (size_t i = 0; i < count; i++)
            at[i] = (int32_t)(check_chance(c, 40) ? check_range(c, INT32_MIN, INT32_MAX)
                                                  : check_range(c, -2, d[k] + 1));
        a.at[k] = at;
    }
    void *out[2];
    check_outputs(c, "densities", count, sizeof(int16_t), sizeof(int16_t), out);
    check_note(c, "%zu voxels of %d x %d x %d in chunks of %d", count, d[0], d[1], d[2], n);
    b = a;
    a.densities = out[0];
    b.densities = out[1];
    if (check_both(c, call, &a, &b))
        check_same(c, "densities", CHECK_I16, out[0], out[1], count);
}

CHECK_CPU_SLOT(sample)
extern const check_kernel check_sample;
const check_kernel check_sample = {.name = "sample", .of = sample_of, .test = test, .cases = 300};
