/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the search for the lattice on which the positions of a CT text lie. The tests use common spacings, written with
 * few digits and with many. A property test compares the result with the result of a simple search.
 *
 * Covers: AR-CT-3, AR-CT-7
 */
#include "harness.h"

#include "io/text/lattice.h"

enum { MAX = 1200 };

typedef struct axis_text {
    ost_pm value[MAX];
    int64_t line[MAX];
    int32_t step[MAX]; /* true number of steps from the first layer to each layer */
    ost_lattice_axis axis;
} axis_text;

static int64_t unit_of(int places)
{
    int64_t unit = 1000000000;
    for (; places > 0; places--)
        unit /= 10;
    return unit;
}

/* Rounds value to a multiple of unit, half to even, as printf does. */
static ost_pm rounded(ost_pm value, int64_t unit)
{
    ost_pm magnitude = value < 0 ? -value : value, units = magnitude / unit, remainder = magnitude % unit;
    units += 2 * remainder > unit || (2 * remainder == unit && units % 2 == 1);
    return value < 0 ? -units * unit : units * unit;
}

static uint32_t units_bit(int places)
{
    return 1u << (places + OST_LATTICE_UNIT_PLACES);
}

/*
 * Fills the axis with the layers origin + step * spacing, rounded to `places` decimal places. Omits the steps for
 * which keep(step) is false.
 */
static void fill(axis_text *a, ost_pm origin, ost_pm spacing, int count, int places, bool (*keep)(int))
{
    size_t n = 0;
    for (int i = 0; i < count; i++) {
        if (keep && !keep(i))
            continue;
        a->value[n] = rounded(origin + i * spacing, unit_of(places));
        a->step[n] = i;
        a->line[n] = (int64_t)n + 1;
        n++;
    }
    a->axis = (ost_lattice_axis){
        .name = 'x', .count = n, .value = a->value, .line = a->line, .units = units_bit(places)};
}

static ost_status find_one(const axis_text *a, ost_pm *spacing, ost_error *err)
{
    const ost_lattice_axis axes[3] = {a->axis, {0}, {0}};
    ost_pm found[3] = {0, 1000000000, 1000000000};
    ost_status status = ost_lattice_find("ct.txt", axes, found, err);
    *spacing = found[0];
    return status;
}

static void finds_common_spacings(void **state)
{
    (void)state;
    /* The expected result is the true spacing if the layers and their digits distinguish the true spacing from
       shorter decimals. */
    static const struct {
        ost_pm spacing, origin;
        int count, places;
    } cases[] = {
        {300000000, 0, 600, 4},
        {300000000, 0, 600, 6},
        {32000000, 0, 600, 4},
        {32000000, 0, 600, 6},
        {488281000, 0, 600, 4},
        {488281000, 0, 600, 6},
        {470000000, -57340000000, 600, 4},
        {470000000, -57340000000, 600, 6},
        {488281250, 0, 600, 6},
        {488281250, -57340000000, 600, 6},
        {488281250, 0, 600, 8},
        {470000000, 0, 256, 2},
        {1000000000, 0, 201, 0},
        {1000000000, 3000000000, 2, 0},
        {2000000000, -7000000000, 40, 0},
        {625000000, 0, 300, 3},
        {700000000, 100000000, 33, 1},
        {976562500, -125000000000, 512, 6},
        {32000000, 17000, 1000, 9},
        {1000000, 0, 50, 3}, /* the least spacing, equal to the unit of its last digit */
    };
    static axis_text a;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_pm found;
        fill(&a, cases[i].origin, cases[i].spacing, cases[i].count, cases[i].places, NULL);
        assert_ok(find_one(&a, &found, &err));
        if (found != cases[i].spacing)
            fail_msg("case %zu: found %lld pm, expected %lld", i, (long long)found, (long long)cases[i].spacing);
    }
}

/*
 * Tests the example of docs/spec/arithmetic.md, AR-CT-3: four decimal places cannot represent the spacing
 * 0.48828125 mm, but 60 layers determine it.
 */
static void many_layers_determine_the_spacing(void **state)
{
    (void)state;
    static axis_text a;
    ost_error err = {0};
    ost_pm found;
    fill(&a, 0, 488281250, 60, 4, NULL);
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 488281250);
    fill(&a, 0, 488281000, 60, 4, NULL);
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 488281000);
}

static bool not_every_third_layer(int i)
{
    return i % 3 != 2 && (i < 20 || i > 90);
}

static void layers_may_be_absent(void **state)
{
    (void)state;
    static axis_text a;
    ost_error err = {0};
    ost_pm found;
    fill(&a, -57340000000, 470000000, 300, 4, not_every_third_layer);
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 470000000);
    fill(&a, -57340000000, 488281250, 300, 6, not_every_third_layer);
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 488281250);
}

/* Tests values without trailing zeros: "0", "0.47", "0.94", "4.7". */
static void trailing_zeros_may_be_dropped(void **state)
{
    (void)state;
    static axis_text a;
    ost_error err = {0};
    ost_pm found;
    fill(&a, 0, 470000000, 300, 2, NULL);
    a.axis.units = units_bit(0) | units_bit(1) | units_bit(2);
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 470000000);
    /* With six significant digits, as printed by %g, values from 100 on have fewer decimal places. */
    fill(&a, 0, 488281250, 400, 6, NULL);
    for (size_t i = 0; i < a.axis.count; i++)
        a.value[i] = rounded((ost_pm)i * 488281250, unit_of(a.value[i] >= 100000000000  ? 3
                                                            : a.value[i] >= 10000000000 ? 4
                                                            : a.value[i] >= 1000000000  ? 5
                                                                                        : 6));
    a.axis.units = units_bit(0) | units_bit(1) | units_bit(2) | units_bit(3) | units_bit(4) | units_bit(5) |
                   units_bit(6);
    assert_ok(find_one(&a, &found, &err));
    /* With positions of three decimal places, 400 layers determine the spacing to within 10^6 / 400 pm. */
    assert_true(found >= 488281250 - 2500 && found <= 488281250 + 2500);
}

/* A third of a millimetre is not a finite decimal, so the result is the nearest picometre. */
static void spacing_that_is_not_a_finite_decimal(void **state)
{
    (void)state;
    static axis_text a;
    ost_error err = {0};
    ost_pm found;
    for (int i = 0; i < 600; i++) {
        a.value[i] = (i * INT64_C(1000000000) * 2 + 3) / 6; /* i / 3 mm to the nearest pm */
        a.line[i] = i + 1;
    }
    a.axis = (ost_lattice_axis){.name = 'x', .count = 600, .value = a.value, .line = a.line, .units = units_bit(9)};
    assert_ok(find_one(&a, &found, &err));
    assert_true(found == 333333333);
}

static void axes_share_a_spacing(void **state)
{
    (void)state;
    static axis_text x, y, z;
    ost_error err = {0};
    /*
     * The spacing along x and y is 0.48828125 mm, and positions have six decimal places. The ten layers along y are
     * also consistent with the shorter decimal 0.4882812 mm; the 256 layers along x are not.
     */
    fill(&x, 0, 488281250, 256, 6, NULL);
    fill(&y, 0, 488281250, 10, 6, NULL);
    fill(&z, 0, 1000000000, 30, 6, NULL);
    ost_pm alone;
    assert_ok(find_one(&y, &alone, &err));
    assert_true(alone != 488281250);
    ost_lattice_axis axes[3] = {x.axis, y.axis, z.axis};
    ost_pm found[3] = {0, 0, 0};
    assert_ok(ost_lattice_find("ct.txt", axes, found, &err));
    assert_true(found[0] == 488281250);
    assert_true(found[1] == 488281250);
    assert_true(found[2] == 1000000000);
    /*
     * The spacing of an axis may be undetermined. The axis must then not adopt the spacing of
     * another axis if that spacing fits only by chance.
     */
    fill(&z, 0, 500000000, 3, 1, NULL);
    fill(&x, 0, 470000000, 256, 4, NULL);
    fill(&y, 0, 470000000, 256, 4, NULL);
    ost_lattice_axis loose[3] = {x.axis, y.axis, z.axis};
    ost_pm found_loose[3] = {0, 0, 0};
    assert_ok(ost_lattice_find("ct.txt", loose, found_loose, &err));
    assert_true(found_loose[0] == 470000000 && found_loose[1] == 470000000);
    assert_true(found_loose[2] == 500000000);
}

static void refuses_undetermined_spacings(void **state)
{
    (void)state;
    static axis_text a;
    ost_error err = {0};
    ost_pm found;

    fill(&a, 0, 470000000, 1, 4, NULL);
    assert_int_equal(find_one(&a, &found, &err), OST_ERR_INPUT);
    assert_string_equal(err.text, "ct.txt: all samples lie in one layer, x = 0, so the spacing along x cannot be "
                                  "found; give the spacing (--spacing)");

    fill(&a, 0, 470000000, 50, 4, NULL);
    a.value[30] += 100000000;
    assert_int_equal(find_one(&a, &found, &err), OST_ERR_INPUT);
    assert_string_equal(
        err.text,
        "ct.txt:2: x = 0.47 is not a whole number of steps from the lowest; the smallest step is 0.37 mm, from 14.2 "
        "(lines 31 and 32); give the spacing (--spacing)");

    /* Layers with a spacing of 1.3 mm, written without decimals, are at 0 1 3 4 5 6 8 ... mm. These positions must not
       be read as a spacing of 1 mm with absent layers. */
    fill(&a, 0, 1300000000, 50, 0, NULL);
    assert_int_equal(find_one(&a, &found, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "--spacing"));

    fill(&a, 0, 470000000, 2, 9, NULL);
    a.value[1] = 470000000;
    a.value[2] = INT64_C(7000) * OST_PM_PER_MM + 470000000;
    a.value[2] -= a.value[2] % 470000000;
    a.line[2] = 3;
    a.axis.count = 3;
    assert_ok(find_one(&a, &found, &err)); /* the last layer is at step 14,894; the limit is 16,383 */
    a.value[2] += 1500 * INT64_C(470000000);
    assert_int_equal(find_one(&a, &found, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "more than 16383 steps"));
}

/*
 * Finds the spacing by a simple search, which is independent of the bisection in the library. The range of feasible
 * spacings follows from all pairs of layers. The result is a spacing in this range with as few digits as possible.
 */
static ost_pm plain_search(const axis_text *a, int64_t u)
{
    size_t m = a->axis.count;
    int64_t lo = 1, hi = OST_SPACING_MAX;
    for (size_t i = 0; i < m; i++)
        for (size_t j = i + 1; j < m; j++) {
            int64_t k = a->step[j] - a->step[i], d = a->value[j] - a->value[i];
            int64_t from = d - u <= 0 ? 0 : (d - u + k - 1) / k, to = (d + u) / k;
            lo = from > lo ? from : lo;
            hi = to < hi ? to : hi;
        }
    int64_t extent = a->value[m - 1] - a->value[0], n = a->step[m - 1];
    for (int64_t q = 1000000000; q >= 1; q /= 10) {
        int64_t first = (lo + q - 1) / q * q, last = hi / q * q, best = 0, best_off = 0;
        if (first > last)
            continue;
        int64_t near = extent / n / q * q;
        for (int64_t s = near - 3 * q; s <= near + 3 * q; s += q) {
            int64_t off = s * n > extent ? s * n - extent : extent - s * n;
            if (s >= first && s <= last && (best == 0 || off < best_off)) {
                best = s;
                best_off = off;
            }
        }
        if (best == 0) /* the feasible spacings are either all below or all above those that the loop tried */
            best = first > near ? first : last;
        return best;
    }
    return 0;
}

/*
 * Determines which layers are present: the first eight, and those whose bit in keep_mask is set. Each of the first
 * eight layers narrows the range of possible spacings. After the eighth layer, the number of absent layers in a gap is
 * unambiguous. With fewer layers, a spacing near the lower end of the range is ambiguous and must be refused.
 */
static uint64_t keep_mask;
static bool keep_layers_of_mask(int i)
{
    return i < 8 || (keep_mask >> (i % 64) & 1);
}

static void result_equals_a_plain_search(void **state)
{
    (void)state;
    static axis_text a;
    test_rng rng = rng_seeded("result_equals_a_plain_search");
    int found_some = 0;
    for (int round = 0; round < 3000; round++) {
        int places = (int)rng_range(&rng, 2, 9);
        int64_t unit = unit_of(places);
        int digits = (int)rng_range(&rng, 1, 9);
        /*
         * The spacing is at least eight units, so that the step of each layer is unambiguous. The
         * spacing has few digits, as in the files of scanners, or many digits.
         */
        int64_t least = 8 * unit > OST_SPACING_MIN ? 8 * unit : OST_SPACING_MIN;
        ost_pm spacing = rounded(rng_range(&rng, least, least * 20 < 2000000000 ? 2000000000 : least * 20),
                                 unit_of(digits));
        if (spacing < least)
            continue;
        ost_pm origin = rng_range(&rng, -200000000000, 200000000000);
        keep_mask = rng_next(&rng) | rng_next(&rng);
        fill(&a, origin, spacing, (int)rng_range(&rng, 2, 120), places, keep_layers_of_mask);
        ost_error err = {0};
        ost_pm found, expected = plain_search(&a, unit);
        assert_ok(find_one(&a, &found, &err));
        if (expected == 0) /* no decimal of nine digits fits; the error is then at most one picometre per step */
            continue;
        found_some++;
        if (found != expected)
            fail_msg("round %d: found %lld, plain search %lld (spacing %lld, %d places, %zu layers)", round,
                     (long long)found, (long long)expected, (long long)spacing, places, a.axis.count);
    }
    assert_true(found_some > 2000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_common_spacings),
        cmocka_unit_test(many_layers_determine_the_spacing),
        cmocka_unit_test(layers_may_be_absent),
        cmocka_unit_test(trailing_zeros_may_be_dropped),
        cmocka_unit_test(spacing_that_is_not_a_finite_decimal),
        cmocka_unit_test(axes_share_a_spacing),
        cmocka_unit_test(refuses_undetermined_spacings),
        cmocka_unit_test(result_equals_a_plain_search),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
