/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the functions for floor, ceiling and rounding half to even (RHE) with their definitions,
 * in 64 and 128 bits. The divider, which is set up once for many divisions, is compared with these
 * functions.
 * Covers: AR-INT-1, AR-INT-2
 */
#include "harness.h"

#include "core/divider.h"

/* Tests the ties of AR-INT-2 with literal values. */
static void ties_go_to_the_even_neighbour(void **state)
{
    (void)state;
    static const struct {
        int64_t n, d, floor, ceil, rhe;
    } cases[] = {
        {1, 2, 0, 1, 0},     {3, 2, 1, 2, 2},     {5, 2, 2, 3, 2},     {7, 2, 3, 4, 4}, {-1, 2, -1, 0, 0},
        {-3, 2, -2, -1, -2}, {-5, 2, -3, -2, -2}, {-7, 2, -4, -3, -4}, {3, 6, 0, 1, 0}, {9, 6, 1, 2, 2},
        {15, 6, 2, 3, 2},    {-9, 6, -2, -1, -2}, {2, 6, 0, 1, 0},     {4, 6, 0, 1, 1}, {-4, 6, -1, 0, -1},
        {-2, 6, -1, 0, 0},   {8, 6, 1, 2, 1},     {10, 6, 1, 2, 2},    {6, 6, 1, 1, 1}, {0, 6, 0, 0, 0},
        {-6, 6, -1, -1, -1}, {7, 1, 7, 7, 7},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const int64_t n = cases[i].n, d = cases[i].d;
        assert_int_equal(ost_floor_div(n, d), cases[i].floor);
        assert_int_equal(ost_ceil_div(n, d), cases[i].ceil);
        assert_int_equal(ost_rhe_div(n, d), cases[i].rhe);
        assert_int_equal((int64_t)ost_floor_div128(n, d), cases[i].floor);
        assert_int_equal((int64_t)ost_rhe_div128(n, d), cases[i].rhe);
    }
}

/* Checks that q is the RHE quotient: |n - q * d| <= d / 2, and q is even at equality. */
static void assert_nearest(ost_i128 n, ost_i128 d, ost_i128 q)
{
    const ost_i128 off = n - q * d, away = off < 0 ? -off : off;
    assert_true(away < d - away || (away == d - away && (q & 1) == 0));
}

static void small_quotients_equal_the_definition(void **state)
{
    (void)state;
    for (int64_t d = 1; d <= 24; d++)
        for (int64_t n = -200; n <= 200; n++) {
            const int64_t below = ost_floor_div(n, d), above = ost_ceil_div(n, d);
            assert_true(n - below * d >= 0 && n - below * d < d);
            assert_true(above * d - n >= 0 && above * d - n < d);
            assert_nearest(n, d, ost_rhe_div(n, d));
            assert_nearest(n, d, ost_rhe_div128(n, d));
        }
}

static ost_i128 random_wide(test_rng *rng, int bits)
{
    const ost_i128 high = (int64_t)(rng_next(rng) >> 1);
    return (high * 2 * ((ost_i128)1 << 63) | (ost_i128)rng_next(rng)) >> (127 - bits);
}

/* Tests random dividends, and dividends at and next to multiples and half multiples of the divisor. */
static void divider_equals_the_division_functions(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("the divider");
    for (int round = 0; round < 200000; round++) {
        ost_i128 d = random_wide(&rng, (int)rng_range(&rng, 16, 97));
        d = d < 1 << 15 ? 1 << 15 : d;
        if (round % 3 == 0)
            d = ((ost_i128)1 << rng_range(&rng, 16, 97)) + rng_range(&rng, -1, 1);
        const ost_divider by = ost_divider_of(d);
        const int64_t most = INT64_C(1) << (round % 2 ? 46 : rng_range(&rng, 0, 28));
        int64_t q = rng_range(&rng, -most, most);
        while (q > 0 ? q > ((ost_i128)1 << 125) / d : -q > ((ost_i128)1 << 125) / d)
            q /= 2;
        ost_i128 n = q * d;
        switch (rng_range(&rng, 0, 3)) {
        case 0: n += rng_range(&rng, -1, 1); break;
        case 1: n += d / 2 + rng_range(&rng, -1, 1); break;
        case 2: n += random_wide(&rng, 127) % d; break;
        default: break;
        }
        /* If the quotient q is at the bound, `most` or -most, the dividend is exactly q * d, so that no rounded
           quotient exceeds the bound. */
        if (q == most || q == -most)
            n = q * d;
        ost_i128 remainder;
        const int64_t below = ost_floor_by(&by, n, &remainder);
        assert_true(below == ost_floor_div128(n, d));
        assert_true(remainder == n - below * d);
        assert_nearest(n, d, ost_rhe_by(&by, n));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ties_go_to_the_even_neighbour),
        cmocka_unit_test(small_quotients_equal_the_definition),
        cmocka_unit_test(divider_equals_the_division_functions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
