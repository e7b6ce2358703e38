/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Check of the kernel `take`, which removes the hit voxels of bricks and counts them by density class. Densities lie
 * next to the borders of the classes, at the maximum or anywhere, and voxels that are not hit may have any density.
 */
#include "simd/remove_cases.h"

typedef struct take_arguments {
    const ost_take *take;
    int16_t *density;
    const int32_t *number;
    const uint64_t *hits;
    size_t count;
    ost_tally tally;
} take_arguments;

static void call_take(check_fn *kernel, void *with)
{
    take_arguments *a = with;
    ((ost_take_fn *)kernel)(a->take, a->density, a->number, a->hits, a->count, &a->tally);
}

static void some_borders(check *c, ost_take *take)
{
    take->borders = (int)check_range(c, 0, check_chance(c, 2) ? 3 : OST_CLASS_MAX - 1);
    const bool wide = check_chance(c, 4); /* true if some borders are outside the range of densities */
    int64_t at = wide ? check_range(c, INT16_MIN, 10) : check_range(c, 0, take->highest / 2 + 1);
    for (int b = 0; b < take->borders; b++) {
        take->border[b] = (int16_t)at;
        at += 1 + (check_chance(c, 3) ? 0 : check_range(c, 0, (wide ? INT16_MAX : take->highest) / OST_CLASS_MAX));
        at = at > INT16_MAX - (OST_CLASS_MAX - b) ? INT16_MAX - (OST_CLASS_MAX - b) : at;
    }
    if (take->borders > 0 && check_chance(c, 4))
        take->border[take->borders - 1] = check_chance(c, 2) ? INT16_MAX
                                                             : (int16_t)(take->highest > take->border[take->borders - 1]
                                                                             ? take->highest
                                                                             : INT16_MAX);
}

static void test_take(check *c)
{
    static const int32_t highest[] = {1, 2, 150, 255, 256, 1000, 8191, 8192, 16383, 16384, 32766, 32767};
    static const size_t counts[] = {0, 1, 2, 15, 16, 17, 511, 512, 513, 1024, 1025, 1100};
    ost_take *take = check_input(c, "take", 1, sizeof *take, _Alignof(ost_take));
    *take = (ost_take){.highest = check_chance(c, 2) ? highest[check_range(c, 0, 11)]
                                                     : (int32_t)check_range(c, 1, 32767),
                       .apply = check_chance(c, 2)};
    some_borders(c, take);
    const size_t count = check_chance(c, 4) ? counts[check_range(c, 0, 11)] : (size_t)check_range(c, 0, 70);
    const int32_t bricks = (int32_t)(count + (size_t)check_range(c, 0, 20));
    int32_t *number = check_input(c, "number", count, sizeof *number, sizeof *number);
    uint64_t *hits = check_input(c, "hits", count, sizeof *hits, sizeof *hits);
    some_numbers(c, number, count, bricks);
    /* 0 if each brick has one hit, 1 if each brick has a random number of hits, 2 if all voxels are hit */
    const int full = (int)check_range(c, 0, 2);
    for (size_t i = 0; i < count; i++)
        hits[i] = full == 2 ? UINT64_MAX : full == 1 ? rng_next(&c->rng) | 1 : UINT64_C(1) << check_range(c, 0, 63);
    const size_t voxels = 64 * (size_t)bricks;
    void *density[2];
    check_outputs(c, "density", voxels, sizeof(int16_t), 64, density);
    int16_t *d = density[0];
    /* 0 if all densities are the maximum, 1 if they are next to class borders, 2 if they are random */
    const int dense = (int)check_range(c, 0, 2);
    for (size_t i = 0; i < voxels; i++) { /* Voxels that are not hit may have any density. */
        int64_t v = dense == 0 ? take->highest : check_range(c, 1, take->highest);
        if (dense == 1 && take->borders > 0)
            v = take->border[check_range(c, 0, take->borders - 1)] - check_range(c, 0, 1);
        d[i] = (int16_t)(v < 1 ? 1 : v > take->highest ? take->highest : v);
    }
    if (check_chance(c, 2)) {
        uint64_t *hit = calloc((size_t)bricks + 1, sizeof *hit);
        for (size_t i = 0; hit && i < count; i++)
            hit[number[i]] = hits[i];
        for (size_t i = 0; hit && i < voxels; i++)
            if (!(hit[i / 64] >> (i % 64) & 1))
                d[i] = check_chance(c, 2) ? INT16_MAX : (int16_t)rng_next(&c->rng);
        free(hit);
    }
    memcpy(density[1], density[0], voxels * sizeof *d);
    take_arguments a = {take, density[0], number, hits, count, {{0}, {0}}};
    /* The tally begins with random values, because the kernel must add to it. */
    for (int i = 0; i < OST_CLASS_MAX; i++) {
        a.tally.voxels[i] = check_chance(c, 2) ? 0 : rng_next(&c->rng) >> 1;
        a.tally.density[i] = check_chance(c, 2) ? 0 : rng_next(&c->rng) >> 1;
    }
    take_arguments b = a;
    b.density = density[1];
    check_note(c, "%zu bricks, highest %d, %d borders, apply %d", count, take->highest, take->borders, take->apply);
    if (!check_both(c, call_take, &a, &b))
        return;
    check_same(c, "density", CHECK_I16, density[0], density[1], voxels);
    check_same(c, "tally->voxels", CHECK_U64, a.tally.voxels, b.tally.voxels, OST_CLASS_MAX);
    check_same(c, "tally->density", CHECK_U64, a.tally.density, b.tally.density, OST_CLASS_MAX);
}

static void bench_take(check_bench *b)
{
    static _Alignas(64) int16_t density[OST_UNIT_BRICKS * 64];
    static int32_t number[OST_UNIT_BRICKS];
    static uint64_t hits[OST_UNIT_BRICKS];
    for (int i = 0; i < OST_UNIT_BRICKS; i++) {
        number[i] = i;
        hits[i] = UINT64_C(0x0f3f7fff37137f01) >> (i % 7) | 1;
        for (int v = 0; v < 64; v++)
            density[64 * i + v] = (int16_t)(120 + (v * i) % 900);
    }
    ost_take take = {.borders = 2, .border = {150, 650}, .highest = 1020};
    take_arguments a = {&take, density, number, hits, 200, {{0}, {0}}};
    bench_time(b, "200 bricks, 3 classes, counted", call_take, NULL, &a, 200, "brick");
    take.apply = true;
    bench_time(b, "the same, taken", call_take, NULL, &a, 200, "brick");
}

CHECK_CPU_SLOT(take)
extern const check_kernel check_take;
const check_kernel check_take = {.name = "take", .of = take_of, .test = test_take, .bench = bench_take, .cases = 600};
