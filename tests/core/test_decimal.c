/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the conversions of decimals and floats to integers and picometres are exact.
 * Covers: AR-INT-1, AR-INT-2, AR-LEN-1, AR-LEN-2, AR-LEN-3, AR-LEN-4, AR-LEN-5
 */
#include "harness.h"

#include <osteon/length.h>

#include <locale.h>

#include "core/integer.h"
#include "core/shortest.h"

static ost_decimal decimal(const char *text)
{
    ost_decimal d = {0};
    const char *end = text + strlen(text);
    if (ost_decimal_read(text, end, &d) != end)
        fail_msg("only a part of '%s' was read", text);
    return d;
}

static int64_t pm(const char *text)
{
    ost_pm value = 0;
    ost_error err = {0};
    assert_ok(ost_pm_parse(text, &value, &err));
    return value;
}

static void halves_are_rounded_to_even(void **state)
{
    (void)state;
    static const struct {
        int64_t n, d, floor, rhe;
    } row[] = {
        {7, 2, 3, 4},
        {5, 2, 2, 2},
        {-5, 2, -3, -2},
        {-7, 2, -4, -4},
        {1, 3, 0, 0},
        {-1, 3, -1, 0},
        {2, 3, 0, 1},
        {-2, 3, -1, -1},
        {INT64_MAX, 1, INT64_MAX, INT64_MAX},
        {INT64_MIN, 1, INT64_MIN, INT64_MIN},
        {INT64_MAX, INT64_MAX, 1, 1},
        {INT64_MAX - 1, INT64_MAX, 0, 1},
    };
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        assert_int_equal(ost_floor_div(row[i].n, row[i].d), row[i].floor);
        assert_int_equal(ost_rhe_div(row[i].n, row[i].d), row[i].rhe);
        assert_int_equal((int64_t)ost_rhe_div128(row[i].n, row[i].d), row[i].rhe);
    }
    assert_int_equal(ost_ceil_div(7, 2), 4);
    assert_int_equal(ost_ceil_div(-7, 2), -3);
}

/* A decimal with an integer value up to 2^64 - 1 must be recognized in any notation. */
static void integer_values_are_recognized(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        uint64_t magnitude;
        bool is;
    } row[] = {
        {"0", 0, true},
        {"-0.000", 0, true},
        {"0e9999", 0, true},
        {"0e-9999", 0, true},
        {"7", 7, true},
        {"-7.0", 7, true},
        {"1.2e2", 120, true},
        {"1200e-2", 12, true},
        {"1205e-2", 0, false},
        {"0.5", 0, false},
        {"1e-1", 0, false},
        {"9223372036854775807", INT64_MAX, true},
        {"-9223372036854775808", UINT64_C(1) << 63, true},
        {"18446744073709551615", UINT64_MAX, true},
        {"18446744073709551616", 0, false},
        {"184467440737095516150e-1", UINT64_MAX, true},
        {"18446744073709551615.000000000000000000000000000000000", UINT64_MAX, true},
        {"18446744073709551615.000000000000000000000000000000001", 0, false},
        {"1e19", UINT64_C(10000000000000000000), true},
        {"1e20", 0, false},
        {"1e9999", 0, false},
        {"1e-9999", 0, false},
        {"0.00000000000000000000000000000000000000000000000000012e53", 12, true},
        {"99999999999999999999999999999999999999999999", 0, false},
    };
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        const ost_decimal d = decimal(row[i].text);
        uint64_t magnitude = 99;
        if (ost_decimal_integer(&d, &magnitude) != row[i].is || (row[i].is && magnitude != row[i].magnitude))
            fail_msg("%s: the integer value is %llu, expected %llu", row[i].text, (unsigned long long)magnitude,
                     (unsigned long long)row[i].magnitude);
    }
}

static void decimals_are_read_as_written(void **state)
{
    (void)state;
    ost_decimal d = decimal("-57.3400e1");
    assert_int_equal(d.mantissa, -573400);
    assert_int_equal(d.exponent, -3);
    assert_int_equal(d.places, 3);
    assert_true(d.negative);
    d = decimal("12e3");
    assert_int_equal(d.places, -3);
    d = decimal("-0");
    assert_true(d.negative && d.mantissa == 0);
    d = decimal(".5");
    assert_int_equal(d.mantissa, 5);
    d = decimal("5.");
    assert_int_equal(d.places, 0);
    d = decimal("0.0000000000000000000000001");
    assert_int_equal(d.mantissa, 1);
    assert_int_equal(d.exponent, -25);
    d = decimal("1234567890123456789000");
    assert_int_equal(d.mantissa, INT64_C(123456789012345678));
    assert_int_equal(d.exponent, 4);
    assert_int_equal(d.tail, INT64_C(900000000000000000));
    assert_true(d.inexact && !d.more);
    d = decimal("0.1234567890123456789012345678901234560001");
    assert_int_equal(d.tail, INT64_C(901234567890123456));
    assert_true(d.more);
}

static void invalid_decimals_are_refused(void **state)
{
    (void)state;
    static const char *const none[] = {"", "-", "+", ".", "e5", "nan", "inf", "-inf", "x1", " 1", "--1", "1e99999"};
    ost_decimal d;
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        assert_null(ost_decimal_read(none[i], none[i] + strlen(none[i]), &d));
    const char *text = "1.5e+x";
    assert_ptr_equal(ost_decimal_read(text, text + strlen(text), &d), text + 3);
    text = "0x10";
    assert_ptr_equal(ost_decimal_read(text, text + strlen(text), &d), text + 1);
}

static void picometres_round_half_to_even(void **state)
{
    (void)state;
    assert_int_equal(pm("0.48828125"), INT64_C(488281250));
    assert_int_equal(pm("0.47"), INT64_C(470000000));
    assert_int_equal(pm("-57.34"), INT64_C(-57340000000));
    assert_int_equal(pm("0.0000000005"), 0);
    assert_int_equal(pm("0.0000000015"), 2);
    assert_int_equal(pm("0.0000000025"), 2);
    assert_int_equal(pm("-0.0000000015"), -2);
    assert_int_equal(pm("0.00000000050000000000000000000000001"), 1);
    assert_int_equal(pm("1e-50"), 0);
    assert_int_equal(pm("8000"), OST_LENGTH_MAX);
    ost_pm value;
    assert_int_equal(ost_pm_parse("8000.000000001", &value, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pm_parse("1e300", &value, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pm_parse("1 mm", &value, NULL), OST_ERR_INPUT);
    assert_int_equal(ost_pm_parse("", &value, NULL), OST_ERR_INPUT);
}

static void floats_represent_their_shortest_decimal(void **state)
{
    (void)state;
    ost_pm value;
    assert_true(ost_pm_from_float(0.47f, &value));
    assert_int_equal(value, 470000000);
    assert_true(ost_pm_from_float(0.488281f, &value));
    assert_int_equal(value, 488281000);
    assert_true(ost_pm_from_float(-57.34f, &value));
    assert_int_equal(value, INT64_C(-57340000000));
    /*
     * By the exception of AR-LEN-4, each of the floats 431/512 and -101843/512 represents its exact value, which has
     * nine decimal places. The exception does not apply to 0.4882812f, which is not a multiple of 1/512, or to 4.25f,
     * which needs only three digits.
     */
    assert_true(ost_pm_from_float(0.841796875f, &value));
    assert_int_equal(value, 841796875);
    assert_true(ost_pm_from_float(0.8417969f, &value));
    assert_int_equal(value, 841796875);
    assert_true(ost_pm_from_float(-198.912109375f, &value));
    assert_int_equal(value, INT64_C(-198912109375));
    assert_true(ost_pm_from_float(0.4882812f, &value));
    assert_int_equal(value, 488281200);
    assert_true(ost_pm_from_float(4.25f, &value));
    assert_int_equal(value, INT64_C(4250000000));
    assert_true(ost_pm_from_double(0.1, &value));
    assert_int_equal(value, 100000000);
    /* The binary value of 0.47f is 0.4699999988079071... mm. */
    assert_true(ost_pm_from_binary((double)0.47f, &value));
    assert_int_equal(value, 469999999);
    assert_true(ost_pm_from_binary(0.0, &value));
    assert_int_equal(value, 0);
    assert_true(ost_pm_from_binary(5e-324, &value));
    assert_int_equal(value, 0);
    assert_false(ost_pm_from_float(strtof("nan", NULL), &value));
    assert_false(ost_pm_from_double(strtod("inf", NULL), &value));
    assert_false(ost_pm_from_binary(8000.1, &value));
}

/* A printed length is exact and as short as possible; parsing it gives the same integer. */
static void format_and_parse_agree(void **state)
{
    (void)state;
    char text[OST_PM_TEXT];
    assert_string_equal(ost_pm_format(470000000, text), "0.47");
    assert_string_equal(ost_pm_format(INT64_C(-57340000000), text), "-57.34");
    assert_string_equal(ost_pm_format(0, text), "0");
    assert_string_equal(ost_pm_format(-1, text), "-0.000000001");
    test_rng rng = rng_seeded("format_and_parse_agree");
    for (int i = 0; i < 20000; i++) {
        ost_pm value = rng_range(&rng, -OST_LENGTH_MAX, OST_LENGTH_MAX);
        assert_int_equal(pm(ost_pm_format(value, text)), value);
    }
}

/* Compares the scaling of a decimal by 2^30 with a long division that computes one digit after another. */
static void q30_agrees_with_long_division(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("q30_agrees_with_long_division");
    for (int i = 0; i < 20000; i++) {
        int64_t m = rng_range(&rng, 0, INT64_C(1000000000000));
        char text[64];
        snprintf(text, sizeof text, "0.%012lld", (long long)m);
        ost_decimal d = decimal(text);
        int64_t scaled;
        assert_true(ost_decimal_scale(&d, UINT64_C(1) << 30, &scaled, NULL));
        /* The error |scaled * 10^12 - m * 2^30| is at most 10^12 / 2. If it equals this bound, `scaled` is even. */
        __int128 off = (__int128)scaled * INT64_C(1000000000000) - ((__int128)m << 30);
        off = off < 0 ? -off : off;
        assert_true(off < INT64_C(500000000000) || (off == INT64_C(500000000000) && scaled % 2 == 0));
    }
}

/* The ties (k + 1/2) / 2^30 need 31 decimal places. Each tie is tested exactly, and with one more digit appended. */
static void long_ties_are_decided_exactly(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int64_t q30;
    } row[] = {
        {"0.5000000004656612873077392578125", (INT64_C(1) << 29)},          /* 2^29 + 1/2, rounded to even */
        {"0.5000000013969838619232177734375", (INT64_C(1) << 29) + 2},      /* 2^29 + 3/2, rounded to even */
        {"0.50000000046566128730773925781250000001", (INT64_C(1) << 29) + 1},
        {"0.500000000465661287307739257812500000000000000000000001", (INT64_C(1) << 29) + 1},
        {"0.5000000004656612873077392578124999999999", INT64_C(1) << 29},
        {"-0.5000000013969838619232177734375", -(INT64_C(1) << 29) - 2},
    };
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        ost_decimal d = decimal(row[i].text);
        int64_t q30 = 0;
        assert_true(ost_decimal_scale(&d, UINT64_C(1) << 30, &q30, NULL));
        if (q30 != row[i].q30)
            fail_msg("%s gives %lld, expected %lld", row[i].text, (long long)q30, (long long)row[i].q30);
    }
    bool exact = true;
    int64_t value = 0;
    ost_decimal d = decimal("123456789012345678.5");
    assert_true(ost_decimal_scale(&d, 1, &value, &exact));
    assert_int_equal(value, INT64_C(123456789012345678));
    assert_false(exact);
    d = decimal("1234567890123456789");
    assert_true(ost_decimal_scale(&d, 1, &value, &exact));
    assert_int_equal(value, INT64_C(1234567890123456789));
    assert_true(exact);
    d = decimal("1234567890123456789e-1");
    assert_true(ost_decimal_scale(&d, 1, &value, &exact));
    assert_int_equal(value, INT64_C(123456789012345679));
    d = decimal("9223372036854775808");
    assert_false(ost_decimal_scale(&d, 1, &value, &exact));
}

/*
 * Converts output of printf from locales whose decimal sign is a comma, an Arabic separator of two bytes, or a point.
 */
static void any_decimal_sign_becomes_a_point(void **state)
{
    (void)state;
    static const char *const cases[][2] = {{"1,5e+00", "1.5e+00"},
                                           {"-4,88281e-04", "-4.88281e-04"},
                                           {"1\xd9\xab"
                                            "25e+01",
                                            "1.25e+01"},
                                           {"7.0e-07", "7.0e-07"},
                                           {"3e+02", "3e+02"},
                                           {"-3e-308", "-3e-308"}};
    char text[32];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(text, sizeof text, "%s", cases[i][0]);
        ost_point_put_back(text);
        assert_string_equal(text, cases[i][1]);
    }
    /* All locales installed on this machine give the same picometres. */
    static const char *const locales[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "ps_AF.UTF-8", "fa_IR.UTF-8", "C"};
    for (size_t i = 0; i < sizeof locales / sizeof *locales; i++) {
        if (!setlocale(LC_NUMERIC, locales[i]))
            continue;
        ost_pm pm = 0;
        assert_true(ost_pm_from_float(0.488281f, &pm));
        assert_int_equal(pm, 488281000);
        assert_true(ost_pm_from_double(-57.34, &pm));
        assert_int_equal(pm, INT64_C(-57340000000));
    }
    setlocale(LC_NUMERIC, "C");
}

static void limits_of_exponents_and_lengths(void **state)
{
    (void)state;
    ost_decimal d;
    int64_t value = -1;
    const char *text = "1e-9999";
    assert_ptr_equal(ost_decimal_read(text, text + 7, &d), text + 7);
    assert_true(ost_decimal_scale(&d, 1, &value, NULL));
    assert_int_equal(value, 0);
    text = "1e-10000";
    assert_null(ost_decimal_read(text, text + 8, &d));
    /* The product of the digits and the scale is 1.8 * 10^37, the greatest possible product. Divided by 10^37, it is
       rounded to 2. */
    text = "999999999999999999e-37";
    assert_non_null(ost_decimal_read(text, text + strlen(text), &d));
    assert_true(ost_decimal_scale(&d, UINT64_MAX, &value, NULL));
    assert_int_equal(value, 2);
    ost_pm pm;
    assert_true(ost_pm_from_binary(8000.0, &pm));
    assert_int_equal(pm, OST_LENGTH_MAX);
    assert_false(ost_pm_from_binary(0x1.f400000000001p12, &pm)); /* the next double above 8000 */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_are_rounded_to_even),
        cmocka_unit_test(integer_values_are_recognized),
        cmocka_unit_test(decimals_are_read_as_written),
        cmocka_unit_test(invalid_decimals_are_refused),
        cmocka_unit_test(picometres_round_half_to_even),
        cmocka_unit_test(floats_represent_their_shortest_decimal),
        cmocka_unit_test(any_decimal_sign_becomes_a_point),
        cmocka_unit_test(format_and_parse_agree),
        cmocka_unit_test(long_ties_are_decided_exactly),
        cmocka_unit_test(q30_agrees_with_long_division),
        cmocka_unit_test(limits_of_exponents_and_lengths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
