/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Inputs that are shared by the checks of the kernels `blocks`, `split`, `match_tables`, `match` and `take`, and the
 * workload of the benchmarks of `split` and `match`.
 */
#ifndef OST_TESTS_SIMD_REMOVE_CASES_H
#define OST_TESTS_SIMD_REMOVE_CASES_H

#include <stdlib.h>
#include <string.h>

#include "cpu/kernels.h"
#include "simd/check.h"
#include "simd/solids.h"

static const int32_t extremes[] = {INT32_MIN, INT32_MAX, 0, -1};

/* Fills the unused elements after the end of a list with random data. The content of these elements is unspecified. */
static inline void garbage(check *c, ost_cubes *cubes)
{
    for (size_t i = cubes->count; i < OST_UNIT_BRICKS + OST_CUBES_SLACK; i++) {
        for (int a = 0; a < 3; a++)
            cubes->u[a][i] = check_chance(c, 2) ? extremes[check_range(c, 0, 3)] : (int32_t)rng_next(&c->rng);
        cubes->number[i] = (int32_t)rng_next(&c->rng);
    }
}

/* Chooses `count` different numbers below `limit`, in random or in ascending order. */
static inline void some_numbers(check *c, int32_t *number, size_t count, int32_t limit)
{
    enum { LIMIT_MAX = 4096 };
    int32_t all[LIMIT_MAX];
    for (int32_t i = 0; i < limit; i++)
        all[i] = i;
    const bool shuffled = check_chance(c, 2);
    for (size_t i = 0; i < count; i++) {
        const size_t j = shuffled ? (size_t)check_range(c, (int64_t)i, limit - 1) : i;
        number[i] = all[j];
        all[j] = all[i];
    }
}

/* Computes the tables of all instruction sets, so that any kernel can read the tables that it needs. */
static inline void make_tables(ost_match *match)
{
    if (!match->windows && !match->wide)
        return;
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        ost_cpu_kernels kernels;
        ost_cpu_kernels_fill(&kernels, (ost_isa)isa);
        if (ost_isa_available((ost_isa)isa))
            kernels.match_tables(match);
    }
}

/* The workload of a benchmark: a ball with a diameter of 48 tool voxels around a unit of 32^3 bone voxels. */
typedef struct scene {
    ost_shape shape;
    ost_split split[2];
    ost_match match;
    ost_cubes blocks, cubes, bricks;
    ost_numbers inside, inside_bricks;
    uint64_t occupancy[OST_UNIT_BRICKS];
    _Alignas(64) uint64_t hits[OST_UNIT_BRICKS + OST_CUBES_SLACK];
} scene;

static inline scene *scene_make(void)
{
    enum { D = 48 };
    static _Alignas(64) scene s;
    static uint64_t rows[D * D]; /* one word per row */
    const int32_t step[3][3] = {{900000, 300000, 100000}, {-290000, 880000, 210000}, {-30000, -230000, 925000}};
    for (int32_t i = 0; i < D * D * D; i++) {
        const int32_t x = 2 * (i % D) + 1 - D, y = 2 * (i / D % D) + 1 - D, z = 2 * (i / D / D) + 1 - D;
        rows[i / D] |= (uint64_t)(x * x + y * y + z * z < D * D) << (i % D);
    }
    ost_error err = {0};
    if (ost_shape_make(rows, 1, (ost_dims){D, D, D}, 985000, &s.shape, &err) != OST_OK)
        exit(99);
    ost_split_make(step, 16, &s.shape.cells, &s.split[0]);
    ost_split_make(step, 8, &s.shape.cells, &s.split[1]);
    ost_match_make(step, &s.shape, &s.match);
    make_tables(&s.match);
    for (int b = 0; b < 8; b++) {
        for (int a = 0; a < 3; a++)
            s.blocks.u[a][b] = 3 * (1 << 20) +
                               16 * ((b & 1) * step[0][a] + (b >> 1 & 1) * step[1][a] + (b >> 2) * step[2][a]);
        s.blocks.number[b] = b;
    }
    s.blocks.count = 8;
    memset(s.occupancy, 0xff, sizeof s.occupancy);
    ost_split_scalar(&s.split[0], &s.shape.cells, &s.blocks, NULL, &s.cubes, &s.inside);
    ost_split_scalar(&s.split[1], &s.shape.cells, &s.cubes, s.occupancy, &s.bricks, &s.inside_bricks);
    ost_match_scalar(&s.match, &s.bricks, s.hits);
    return &s;
}

#endif
