/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernel gather_row. The first 130 cases use each count from 0 to 64 twice, in ascending order;
 * later cases use random counts. Neighbouring elements of a map are equal, consecutive or farther apart. Some
 * maps span about as many elements as a register holds.
 */
#include "simd/check.h"

#include "cpu/kernels.h"

typedef struct arguments {
    const int16_t *from;
    const int32_t *map;
    int count;
    int16_t *to;
} arguments;

static void call(check_fn *kernel, void *with)
{
    const arguments *a = with;
    ((ost_gather_row_fn *)kernel)(a->from, a->map, a->count, a->to);
}

/* Makes an ascending map that begins with `first`. */
static void make_map(check *c, int32_t *map, int count, int32_t first)
{
    const int kind = (int)check_range(c, 0, 6);
    const int64_t step = check_range(c, 1, kind == 1 ? 3000 : 12);
    int32_t at = first;
    for (int i = 0; i < count; i++) {
        map[i] = at;
        switch (kind) {
        case 0: /* consecutive elements, or always the same element */
            at += step > 6;
            break;
        case 1: /* indices with a constant fractional stride, as in resampling */
            at = first + (int32_t)((i + 1) * step / 1000);
            break;
        case 2:
            at += (int32_t)check_range(c, 0, 1);
            break;
        case 3:
            at += (int32_t)check_range(c, 0, 3);
            break;
        case 4: /* far apart */
            at += (int32_t)check_range(c, 0, 40);
            break;
        case 5: /* rare large steps */
            at += check_chance(c, 16) ? (int32_t)check_range(c, 25, 70) : 1;
            break;
        default: /* a few small steps, so that the map spans about 32 or 64 elements */
            at += check_chance(c, 30) ? (int32_t)check_range(c, 1, 4) : 1;
            break;
        }
    }
}

static void test(check *c)
{
    const int count = c->number < 130 ? c->number % 65 : (int)check_range(c, 0, 64);
    int32_t *map = check_input(c, "map", (size_t)count, sizeof *map, sizeof *map);
    make_map(c, map, count, check_chance(c, 2) ? 0 : (int32_t)check_range(c, 0, 300));
    const size_t reach = count > 0 ? (size_t)map[count - 1] + 1 : 0;
    int16_t *from = check_input(c, "from", reach, sizeof *from, sizeof *from);
    for (size_t i = 0; i < reach; i++)
        from[i] = (int16_t)check_range(c, INT16_MIN, INT16_MAX);
    void *to[2];
    check_outputs(c, "to", (size_t)count, sizeof(int16_t), sizeof(int16_t), to);
    check_note(c, "%d elements of %zu", count, reach);
    arguments a = {from, map, count, to[0]}, b = {from, map, count, to[1]};
    if (check_both(c, call, &a, &b))
        check_same(c, "to", CHECK_I16, to[0], to[1], (size_t)count);
}

static void bench(check_bench *b)
{
    static int16_t from[256], to[64];
    static int32_t map[64];
    arguments a = {from, map, 64, to};
    for (int32_t i = 0; i < 64; i++)
        map[i] = i * 47 / 100;
    bench_time(b, "64 elements, each twice", call, NULL, &a, 64, "element");
    for (int32_t i = 0; i < 64; i++)
        map[i] = i * 2;
    bench_time(b, "64 elements, every second", call, NULL, &a, 64, "element");
}

CHECK_CPU_SLOT(gather_row)
extern const check_kernel check_gather_row;
const check_kernel check_gather_row = {
    .name = "gather_row", .of = gather_row_of, .test = test, .bench = bench, .cases = 1300};
