/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the conversion of file elements to densities. Floats without scaling are compared with rint in its
 * default mode, which is another implementation of the same rule. Scaled values are compared with long
 * double arithmetic wherever this arithmetic is exact.
 *
 * Covers: AR-FILE-4
 */
#include "harness.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "io/volume/element_table.h"

static int16_t convert_one(ost_converter *c, const void *bytes, ost_bad_kind expected)
{
    int16_t out = 12345;
    ost_bad bad;
    size_t done = ost_convert(c, bytes, 1, &out, &bad);
    assert_int_equal(bad.kind, expected);
    assert_int_equal(done, expected == OST_BAD_NONE);
    return out;
}

static void integers_at_their_limits(void **state)
{
    (void)state;
    static const struct {
        ost_element element;
        int64_t value;
        bool fits;
        int16_t clamped;
    } cases[] = {
        {OST_ELEMENT_INT8, -128, true, 0},           {OST_ELEMENT_UINT8, 255, true, 0},
        {OST_ELEMENT_INT16, -32768, true, 0},        {OST_ELEMENT_INT16, 32767, true, 0},
        {OST_ELEMENT_UINT16, 32767, true, 0},        {OST_ELEMENT_UINT16, 32768, false, 32767},
        {OST_ELEMENT_INT32, -32768, true, 0},        {OST_ELEMENT_INT32, -32769, false, -32768},
        {OST_ELEMENT_INT32, INT32_MIN, false, -32768}, {OST_ELEMENT_UINT32, UINT32_MAX, false, 32767},
        {OST_ELEMENT_INT64, 32767, true, 0},         {OST_ELEMENT_INT64, INT64_MIN, false, -32768},
        {OST_ELEMENT_UINT64, 1000, true, 0},         {OST_ELEMENT_UINT64, -1, false, 32767},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int swap = 0; swap < 2; swap++) {
            unsigned char bytes[8];
            size_t size = ost_element_bytes(cases[i].element);
            for (size_t b = 0; b < size; b++)
                bytes[swap ? size - 1 - b : b] = (unsigned char)((uint64_t)cases[i].value >> 8 * b);
            ost_converter c = {.element = cases[i].element, .swap = swap};
            int16_t got = convert_one(&c, bytes, cases[i].fits ? OST_BAD_NONE : OST_BAD_RANGE);
            if (cases[i].fits)
                assert_int_equal(got, cases[i].value);
            c.clamp = true;
            assert_int_equal(convert_one(&c, bytes, OST_BAD_NONE), cases[i].fits ? cases[i].value : cases[i].clamped);
            assert_int_equal(c.clamped, !cases[i].fits);
            assert_int_equal(c.rounded, 0);
        }
    }
}

static void floats_round_half_to_even(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("floats");
    static const double fixed[] = {
        0.0,          -0.0,          0.5,      1.5,      2.5,    -0.5,     -1.5,    0.49999999999999994,
        32767.4,      32767.5,       -32768.5, -32768.6, 5e-324, -1e-300,  1e300,   4503599627370497.5,
        2147483648.0, -2147483649.0, 1023.5,   -1023.5,  1e9,    -32769.0, 32766.5, 0.1,
        -0.0001,      32768.0};
    for (int i = 0; i < 200000; i++) {
        double value = i < (int)(sizeof fixed / sizeof fixed[0]) ? fixed[i]
                       : i % 2
                           ? (double)rng_range(&rng, -140000, 140000) / 4
                           : ldexp((double)rng_range(&rng, -(1LL << 52), 1LL << 52), (int)rng_range(&rng, -120, 10));
        for (int single = 0; single < 2; single++) {
            float f = (float)value;
            double exact = single ? (double)f : value;
            if (!isfinite(exact))
                continue;
            double nearest = rint(exact);
            bool fits = nearest >= -32768 && nearest <= 32767;
            ost_converter c = {.element = single ? OST_ELEMENT_FLOAT32 : OST_ELEMENT_FLOAT64};
            const void *bytes = single ? (const void *)&f : (const void *)&value;
            int16_t got = convert_one(&c, bytes, fits ? OST_BAD_NONE : OST_BAD_RANGE);
            if (fits)
                assert_int_equal(got, (int)nearest);
            assert_int_equal(c.rounded, fits && nearest != exact);
            c.clamp = true;
            got = convert_one(&c, bytes, OST_BAD_NONE);
            assert_int_equal(got, fits ? (int)nearest : exact < 0 ? -32768 : 32767);
        }
    }
}

/* The density of NaN is -1024 by definition (AR-FILE-4); the slope does not apply to it. */
static void nan_is_air_by_option(void **state)
{
    (void)state;
    const float single = -NAN;
    const double twice = (double)NAN, infinite = (double)INFINITY;
    ost_converter c = {.element = OST_ELEMENT_FLOAT32, .nan_as_air = true};
    assert_int_equal(convert_one(&c, &single, OST_BAD_NONE), -1024);
    c.element = OST_ELEMENT_FLOAT64;
    assert_int_equal(convert_one(&c, &twice, OST_BAD_NONE), -1024);
    convert_one(&c, &infinite, OST_BAD_INFINITE);
    c.scaled = true;
    c.slope = (ost_binary){1, 4};
    c.intercept = (ost_binary){100, 0};
    assert_int_equal(convert_one(&c, &twice, OST_BAD_NONE), -1024);
    assert_int_equal(c.nan, 3);
    assert_int_equal(c.rounded + c.clamped, 0);
}

static void nan_and_infinity_are_never_densities(void **state)
{
    (void)state;
    const float single[3] = {NAN, INFINITY, -INFINITY};
    const double twice[3] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int i = 0; i < 3; i++) {
        for (int clamp = 0; clamp < 2; clamp++) {
            ost_bad_kind kind = i == 0 ? OST_BAD_NAN : OST_BAD_INFINITE;
            ost_converter c = {.element = OST_ELEMENT_FLOAT32, .clamp = clamp};
            convert_one(&c, &single[i], kind);
            c.element = OST_ELEMENT_FLOAT64;
            convert_one(&c, &twice[i], kind);
            c.scaled = true;
            c.slope = (ost_binary){1, 1};
            convert_one(&c, &twice[i], kind);
        }
    }
}

/*
 * The product of an int32 and a float32 has at most 31 + 24 = 55 bits. If the exponents are close, the sum of this
 * product and a float32 is therefore exact in the 64 bits of long double.
 */
static void scaling_is_exact(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("scaling");
    if (sizeof(long double) < 16 || LDBL_MANT_DIG < 64)
        skip();
    int checked = 0;
    for (int i = 0; i < 100000; i++) {
        int32_t value = (int32_t)rng_range(&rng, -100000, 100000);
        float slope = (float)rng_range(&rng, -4096, 4096) / 1024.0f;
        float intercept = (float)rng_range(&rng, -8192, 8192) / 4.0f;
        ost_converter c = {.element = OST_ELEMENT_INT32, .scaled = true};
        assert_true(ost_binary_from_double((double)slope, &c.slope));
        assert_true(ost_binary_from_double((double)intercept, &c.intercept));
        long double exact = (long double)value * (long double)slope + (long double)intercept;
        long double nearest = rintl(exact);
        bool fits = nearest >= -32768 && nearest <= 32767;
        int16_t got = convert_one(&c, &value, fits ? OST_BAD_NONE : OST_BAD_RANGE);
        if (fits) {
            assert_int_equal(got, (int)nearest);
            assert_int_equal(c.rounded, exact != nearest);
            checked++;
        } else {
            c.clamp = true;
            assert_int_equal(convert_one(&c, &value, OST_BAD_NONE), exact < 0 ? -32768 : 32767);
        }
    }
    assert_true(checked > 10000);
}

static void scaling_with_extreme_factors(void **state)
{
    (void)state;
    const double slopes[] = {1e300, -1e300, 1e-300, 5e-324};
    for (int i = 0; i < 4; i++) {
        ost_converter c = {.element = OST_ELEMENT_UINT64, .scaled = true, .clamp = true};
        uint64_t value = UINT64_MAX;
        assert_true(ost_binary_from_double(slopes[i], &c.slope));
        assert_true(ost_binary_from_double(-7, &c.intercept));
        assert_int_equal(convert_one(&c, &value, OST_BAD_NONE), i == 0 ? 32767 : i == 1 ? -32768 : -7);
        assert_true(ost_binary_from_double(1e300, &c.intercept));
        assert_int_equal(convert_one(&c, &value, OST_BAD_NONE), i == 1 ? -32768 : 32767);
    }
}

/* Tests a row of floats that contains integers, fractions and one value that is beyond the range of densities. */
static void row_of_floats(void **state)
{
    (void)state;
    static const float row[] = {-32768, 32767, -0.0F, 7, 2.5F, 8, -32768.4F, 9, 32768, 10};
    static const int16_t expected[] = {-32768, 32767, 0, 7, 2, 8, -32768, 9};
    int16_t out[10];
    ost_bad bad;
    ost_converter c = {.element = OST_ELEMENT_FLOAT32};
    assert_int_equal(ost_convert(&c, row, 10, out, &bad), 8);
    assert_memory_equal(out, expected, sizeof expected);
    assert_int_equal(bad.kind, OST_BAD_RANGE);
    assert_string_equal(bad.value, "32768");
    assert_int_equal(c.rounded, 2);
    c = (ost_converter){.element = OST_ELEMENT_FLOAT32, .clamp = true};
    assert_int_equal(ost_convert(&c, row, 10, out, &bad), 10);
    assert_int_equal(out[8], 32767);
    assert_int_equal(out[9], 10);
    assert_int_equal(c.clamped, 1);
}

/*
 * Tests that a table gives the same results as ost_convert: the densities, the counts, and the position and description
 * of the first bad element. The rows consist of random elements of one or two bytes. Some elements cannot be converted.
 */
static void table_equals_conversion(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("table");
    static const ost_element kinds[] = {OST_ELEMENT_INT8, OST_ELEMENT_UINT8, OST_ELEMENT_INT16, OST_ELEMENT_UINT16};
    static const double slopes[] = {1, -1, 0.5, 2.75, 40, 1e-9}, intercepts[] = {0, -1024, 0.5, -32000, 1e6};
    enum { COUNT = 300 };
    int tables = 0, bad_rows = 0, rounded = 0, clamped = 0;
    for (int i = 0; i < 400; i++) {
        ost_converter c = {.element = kinds[rng_range(&rng, 0, 3)],
                           .swap = rng_range(&rng, 0, 1),
                           .clamp = rng_range(&rng, 0, 1),
                           .scaled = rng_range(&rng, 0, 3) > 0};
        assert_true(ost_binary_from_double(slopes[rng_range(&rng, 0, 5)], &c.slope));
        assert_true(ost_binary_from_double(intercepts[rng_range(&rng, 0, 4)], &c.intercept));
        ost_converter expected = c;
        ost_element_table *table = ost_element_table_make(&c, 1 << 16);
        assert_int_equal(table != NULL, c.scaled || c.element == OST_ELEMENT_UINT16);
        tables += table != NULL;
        for (int row = 0; row < 20; row++) {
            unsigned char bytes[2 * COUNT];
            int16_t a[COUNT] = {0}, b[COUNT] = {0};
            ost_bad bad_a, bad_b;
            for (size_t k = 0; k < sizeof bytes; k++)
                bytes[k] = (unsigned char)(row % 2 ? rng_range(&rng, 0, 255) : rng_range(&rng, 0, 3));
            const size_t done = ost_convert(&expected, bytes, COUNT, a, &bad_a);
            assert_int_equal(ost_element_table_convert(table, &c, bytes, COUNT, b, &bad_b), done);
            assert_memory_equal(a, b, done * sizeof a[0]);
            assert_int_equal(bad_a.kind, bad_b.kind);
            assert_string_equal(bad_a.value, bad_b.value);
            bad_rows += done < COUNT;
        }
        assert_int_equal(c.rounded, expected.rounded);
        assert_int_equal(c.clamped, expected.clamped);
        rounded += c.rounded > 0;
        clamped += c.clamped > 0;
        free(table);
    }
    assert_true(tables > 200 && bad_rows > 200 && rounded > 20 && clamped > 20);
}

/* Tests that no table is made for elements that need none, or for volumes with fewer voxels than entries. */
static void table_is_made_only_if_it_saves_time(void **state)
{
    (void)state;
    ost_converter c = {.element = OST_ELEMENT_INT16, .scaled = true, .slope = {1, 0}};
    assert_null(ost_element_table_make(&c, (1 << 16) - 1));
    ost_element_table *table = ost_element_table_make(&c, 1 << 16);
    assert_non_null(table);
    free(table);
    c.scaled = false;
    assert_null(ost_element_table_make(&c, 1 << 16));
    c = (ost_converter){.element = OST_ELEMENT_FLOAT32, .scaled = true, .slope = {1, 0}};
    assert_null(ost_element_table_make(&c, 1 << 30));
    c = (ost_converter){.scaled = true}; /* DICOM, which has its own table */
    assert_null(ost_element_table_make(&c, 1 << 30));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_at_their_limits),
        cmocka_unit_test(floats_round_half_to_even),
        cmocka_unit_test(nan_and_infinity_are_never_densities),
        cmocka_unit_test(nan_is_air_by_option),
        cmocka_unit_test(scaling_is_exact),
        cmocka_unit_test(scaling_with_extreme_factors),
        cmocka_unit_test(row_of_floats),
        cmocka_unit_test(table_equals_conversion),
        cmocka_unit_test(table_is_made_only_if_it_saves_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
