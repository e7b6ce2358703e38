/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs the cases of one kernel and reports the first failure.
 *
 * A case has its own random generator. The seed of the generator depends only on the run's seed, the kernel's name and
 * the case's number. Therefore a case is the same for every instruction set and does not depend on earlier cases.
 */
#include "simd/check.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "cpu/kernels.h"

extern const check_kernel check_gather_row, check_blend_rows, check_stretch_row, check_weigh_rows, check_brick_row,
    check_any_active, check_drain, check_sample, check_blocks, check_split, check_match_tables, check_match, check_take,
    check_vox_mark, check_vox_keys, check_vox_fill, check_vox_expand, check_text_match;

const check_kernel *const check_kernels[] = {
    &check_gather_row,   &check_blend_rows, &check_stretch_row, &check_weigh_rows, &check_brick_row,  &check_any_active,
    &check_drain,        &check_sample,     &check_blocks,      &check_split,      &check_match_tables, &check_match,
    &check_take,         &check_vox_mark,   &check_vox_keys,    &check_vox_fill,   &check_vox_expand, &check_text_match,
};
const int check_kernel_count = sizeof check_kernels / sizeof check_kernels[0];

/* This file does not compile unless every slot has a check in the list above. */
enum {
    CPU_SLOTS = (sizeof(ost_cpu_kernels) - offsetof(ost_cpu_kernels, gather_row)) / sizeof(check_fn *),
    TEXT_KERNELS = 1
};
_Static_assert(sizeof check_kernels / sizeof check_kernels[0] == CPU_SLOTS + TEXT_KERNELS, "a kernel has no check");

/* ------------------------------------------------ functions for a test */

void *check_input(check *c, const char *name, size_t count, size_t size, size_t align)
{
    return guard_take(name, count * size, align, GUARD_INPUT, check_chance(c, 2));
}

void check_outputs(check *c, const char *name, size_t count, size_t size, size_t align, void *both[2])
{
    const bool at_end = check_chance(c, 2);
    for (int i = 0; i < 2; i++)
        both[i] = guard_take(name, count * size, align, GUARD_OUTPUT, at_end);
}

void check_note(check *c, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(c->note, sizeof c->note, format, list);
    va_end(list);
}

/* Reports a failure. Only the first failure of a case is reported. */
static void fail(check *c, check_result result, const char *who, const char *what)
{
    if (c->result != CHECK_GOOD)
        return;
    c->result = result;
    if (!c->quiet)
        printf("FAILED %s, %s, case %d: %s%s\n  (%s)\n", c->name, c->isa, c->number, who, what, c->note);
}

static bool call_one(check *c, check_call_fn *call, check_fn *kernel, void *arguments, const char *who)
{
    char text[300];
    const call_end end = call_kernel(call, kernel, arguments, text, sizeof text);
    if (end != CALL_RETURNED) {
        fail(c, end == CALL_FAULT ? CHECK_FAULT : CHECK_STATE, who, text);
        return false;
    }
    char where[300];
    if (!guard_intact(where, sizeof where)) {
        snprintf(text, sizeof text, "writes %.280s", where);
        fail(c, CHECK_BEYOND, who, text);
        return false;
    }
    return true;
}

bool check_both(check *c, check_call_fn *call, void *a, void *b)
{
    guard_freeze();
    return call_one(c, call, c->scalar, a, "the scalar kernel ") && call_one(c, call, c->other, b, "the kernel ");
}

/* ---------------------------------------------------- comparing results */

static size_t size_of(check_type type)
{
    static const size_t size[] = {[CHECK_I8] = 1,  [CHECK_U8] = 1,  [CHECK_I16] = 2, [CHECK_I32] = 4,
                                  [CHECK_U32] = 4, [CHECK_U64] = 8, [CHECK_BITS] = 8};
    return size[type];
}

static void print_element(check_type type, const void *array, size_t i)
{
    switch (type) {
    case CHECK_I8:
        printf("%20d", ((const int8_t *)array)[i]);
        break;
    case CHECK_U8:
        printf("%20u", ((const uint8_t *)array)[i]);
        break;
    case CHECK_I16:
        printf("%20d", ((const int16_t *)array)[i]);
        break;
    case CHECK_I32:
        printf("%20" PRId32, ((const int32_t *)array)[i]);
        break;
    case CHECK_U32:
        printf("%20" PRIu32, ((const uint32_t *)array)[i]);
        break;
    case CHECK_U64:
        printf("%20" PRIu64, ((const uint64_t *)array)[i]);
        break;
    case CHECK_BITS:
        printf("    %016" PRIx64, ((const uint64_t *)array)[i]);
        break;
    }
}

static void print_table(check_type type, const void *expected, const void *got, size_t count)
{
    enum { SHOWN = 8 };
    const size_t size = size_of(type);
    size_t shown = 0, more = 0;
    printf("       index            expected                 got\n");
    for (size_t i = 0; i < count; i++) {
        if (memcmp((const char *)expected + i * size, (const char *)got + i * size, size) == 0)
            continue;
        if (shown == SHOWN) {
            more++;
            continue;
        }
        printf("  %10zu", i);
        print_element(type, expected, i);
        print_element(type, got, i);
        printf("\n");
        shown++;
    }
    if (more > 0)
        printf("  and %zu more of %zu\n", more, count);
}

bool check_same(check *c, const char *what, check_type type, const void *expected, const void *got, size_t count)
{
    if (c->result != CHECK_GOOD)
        return false;
    if (count == 0 || memcmp(expected, got, count * size_of(type)) == 0)
        return true;
    char text[100];
    snprintf(text, sizeof text, "'%s' differs from the scalar kernel's", what);
    fail(c, CHECK_DIFFERS, "", text);
    if (!c->quiet)
        print_table(type, expected, got, count);
    return false;
}

bool check_that(check *c, bool holds, const char *format, ...)
{
    if (holds)
        return c->result == CHECK_GOOD;
    char text[300];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    fail(c, CHECK_DIFFERS, "", text);
    return false;
}

/* -------------------------------------------------------- running cases */

static uint64_t seed_of_case(uint64_t seed, const char *name, int number)
{
    test_rng rng = {seed};
    uint64_t s = rng_next(&rng);
    for (; *name; name++)
        s = (s ^ (unsigned char)*name) * UINT64_C(0x100000001b3);
    rng.state = s + (uint64_t)number;
    return rng_next(&rng);
}

check_result check_run(const check_kernel *kernel, check_fn *scalar, check_fn *other, const char *isa, uint64_t seed,
                       int first, int count, bool quiet)
{
    for (int number = first; number < first + count; number++) {
        check c = {.rng = {seed_of_case(seed, kernel->name, number)},
                   .number = number,
                   .seed = seed,
                   .scalar = scalar,
                   .other = other,
                   .name = kernel->name,
                   .isa = isa,
                   .quiet = quiet};
        kernel->test(&c);
        guard_reset();
        if (c.result == CHECK_GOOD)
            continue;
        if (!quiet)
            printf("  again: checksimd --seed=%" PRIu64 " --function=%s --isa=%s --case=%d\n", seed, kernel->name, isa,
                   number);
        return c.result;
    }
    return CHECK_GOOD;
}
