/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the classification of differences. The differing grids are written by hand, or computed with an implementation
 * that makes one deliberate mistake (validation/dense).
 *
 * With OST_TEST_LONG=1 the confusion table of all mistakes is printed.
 *
 * Covers: REQ-LOCATE
 */
#include "small_trace.h"

#include "validation/dense/dense.h"
#include "validation/locate/causes.h"
#include "validation/locate/finding.h"
#include "validation/sensitivity.h"

enum { N = 32 };

/* ---------------------------------------------------- grids written by hand */

typedef struct pair {
    int16_t a[N * N * N], b[N * N * N], in[N * N * N];
} pair;

static int64_t at(int x, int y, int z)
{
    return x + N * (y + (int64_t)N * z);
}

/* Makes a ball in which the density of every voxel differs from the densities of its neighbours. */
static pair *make_pair(void)
{
    static pair p;
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++) {
                const int r = (x - 14) * (x - 14) + (y - 15) * (y - 15) + (z - 16) * (z - 16);
                p.a[at(x, y, z)] = (int16_t)(r < 140 ? 200 + x + 20 * y + 3 * z * z : 0);
            }
    memcpy(p.b, p.a, sizeof p.b);
    memcpy(p.in, p.a, sizeof p.in);
    return &p;
}

static pattern_view view_of(const pair *p)
{
    return (pattern_view){
        .a = p->a, .b = p->b, .dims = {N, N, N}, .dims_b = {N, N, N}, .solid_a = 120, .solid_b = 120, .chunk = 16};
}

static void assert_pattern(const pattern_view *v, pattern expected, const char *what)
{
    pattern_list list;
    ost_pattern_find(v, &list);
    if (list.of_all != expected)
        fail_msg("%s: pattern %s, expected %s", what, ost_pattern_name(list.of_all), ost_pattern_name(expected));
    if (expected != PATTERN_UNCLASSIFIED)
        assert_true(list.holds[expected] && list.text[expected][0]);
}

static void patterns_in_hand_made_grids(void **state)
{
    (void)state;
    pair *p = make_pair();
    pattern_view v = view_of(p);
    pattern_list none;
    ost_pattern_find(&v, &none);
    assert_int_equal(none.of_all, PATTERN_UNCLASSIFIED);
    for (int i = 0; i < PATTERNS; i++)
        assert_false(none.holds[i]);

    for (int i = 0; i < N * N * N; i++)
        p->b[i] = (int16_t)(uint16_t)((uint16_t)p->a[i] << 8 | (uint16_t)p->a[i] >> 8);
    assert_pattern(&v, PATTERN_BYTE_ORDER, "values with swapped bytes");

    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++)
                p->b[at(x, y, z)] = p->a[at(y, x, z)];
    assert_pattern(&v, PATTERN_AXIS_SWAP, "x and y exchanged");

    p = make_pair();
    for (int z = 10; z < 20; z++) /* the layers are shifted in only part of the grid */
        for (int y = 8; y < 20; y++)
            for (int x = 8; x < 20; x++)
                p->b[at(x, y, z)] = p->a[at(x, y, z - 1)];
    assert_pattern(&v, PATTERN_SHIFT, "layers shifted by one in a part of the grid");

    p = make_pair();
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++) {
                const int64_t from = x + 48 * (y + (int64_t)N * z);
                p->b[at(x, y, z)] = from < N * N * N ? p->a[from] : 0;
            }
    assert_pattern(&v, PATTERN_ROW_PITCH, "rows read with a pitch of 48 voxels");

    p = make_pair();
    for (int i = at(0, 0, 12); i < at(0, 0, 14); i++)
        p->b[i] = (int16_t)(p->a[i] ? p->a[i] + 9 : 0);
    assert_pattern(&v, PATTERN_OFFSET, "the values of two slices 9 greater");

    p = make_pair();
    for (int i = 0; i < N * N * N; i++)
        p->b[i] = p->a[i] < 700 ? 0 : p->a[i];
    assert_pattern(&v, PATTERN_THRESHOLD, "values below 700 removed");

    p = make_pair();
    for (int i = at(0, 0, 20); i < N * N * N; i++)
        p->b[i] = 0;
    assert_pattern(&v, PATTERN_LOST_TAIL, "all slices from one slice on empty");

    p = make_pair();
    for (int z = 0; z < 16; z++)
        for (int y = 0; y < 16; y++)
            memset(&p->b[at(16, y, z)], 0, 16 * sizeof p->b[0]);
    assert_pattern(&v, PATTERN_LOST_CHUNK, "an empty chunk");

    p = make_pair();
    p->b[at(10, 11, 12)] = 999;
    p->b[at(15, 15, 15)] = 1;
    assert_pattern(&v, PATTERN_SPECKLE, "two single voxels differ");

    p = make_pair();
    for (int y = 12; y < 19; y++)
        for (int x = 12; x < 19; x++)
            for (int z = 12; z < 19; z++)
                p->b[at(x, y, z)] = (int16_t)(2000 + (x * 7 + y * 13 + z * 29) % 50);
    assert_pattern(&v, PATTERN_UNCLASSIFIED, "unrelated values in a cube");
}

/* Tests differences caused by an event. The array `in` is the bone before the event. */
static void patterns_of_events(void **state)
{
    (void)state;
    pair *p = make_pair();
    pattern_view v = view_of(p);
    v.input = PATTERN_BEFORE;
    v.in = p->in;
    v.in_dims = v.dims;
    for (int z = 8; z < 24; z++)
        for (int y = 8; y < 20; y++)
            for (int x = 6; x < 20; x++)
                p->a[at(x, y, z)] = p->b[at(x, y, z)] = 0;
    for (int z = 16; z < 32; z++)
        for (int y = 0; y < 16; y++)
            memcpy(&p->b[at(0, y, z)], &p->in[at(0, y, z)], 16 * sizeof p->b[0]);
    assert_pattern(&v, PATTERN_STALE_CHUNK, "a chunk as it was before the event");
    v.reported_too = true;
    assert_pattern(&v, PATTERN_LOST_CHUNK, "a chunk that was neither cut nor reported");
    memcpy(p->b, p->a, sizeof p->b);
    for (int z = 16; z < 32; z++)
        for (int y = 16; y < 32; y++)
            memcpy(&p->b[at(16, y, z)], &p->in[at(16, y, z)], 16 * sizeof p->b[0]);
    assert_pattern(&v, PATTERN_LOST_TAIL, "the last chunk as it was before the event");

    memcpy(p->b, p->a, sizeof p->b);
    for (int y = 9; y < 19; y++)
        p->b[at(19, y, 12)] = p->in[at(19, y, 12)];
    assert_pattern(&v, PATTERN_BOUNDARY_LAYER, "voxels at the border of the cut");
    p->b[at(12, 14, 14)] = p->in[at(12, 14, 14)]; /* a voxel inside the cut, away from the cut's border */
    assert_pattern(&v, PATTERN_UNCLASSIFIED, "voxels at the border of the cut and a voxel inside the cut");
}

static void patterns_of_tools(void **state)
{
    (void)state;
    pair *p = make_pair();
    pattern_view v = view_of(p);
    v.tool = true;
    v.solid_a = v.solid_b = 1;
    for (int i = 0; i < N * N * N; i++)
        p->a[i] = p->b[i] = p->a[i] != 0;
    for (int y = 12; y < 14; y++)
        memset(&p->b[at(0, y, 15)], 0, N * sizeof p->b[0]);
    assert_pattern(&v, PATTERN_COLUMN_PARITY, "empty rows");
    memcpy(p->b, p->a, sizeof p->b);
    for (int x = 20; x < N; x++)
        p->b[at(x, 15, 16)] = 1;
    assert_pattern(&v, PATTERN_COLUMN_PARITY, "a row filled up to its end");
    memcpy(p->b, p->a, sizeof p->b);
    for (int y = 16; y < N; y++)
        for (int x = 0; x < N; x++)
            p->b[at(x, y, 16)] |= p->b[at(x, y - 1, 16)];
    assert_pattern(&v, PATTERN_CARRIED_ROWS, "rows carried into all following rows");
    for (int x = 0; x < N; x++) /* by the parity rule, a voxel that is solid in both rows becomes empty */
        p->b[at(x, 16, 16)] = (int16_t)(p->a[at(x, 16, 16)] ^ p->b[at(x, 15, 16)]);
    for (int y = 17; y < N; y++)
        for (int x = 0; x < N; x++)
            p->b[at(x, y, 16)] = (int16_t)(p->a[at(x, y, 16)] ^ p->b[at(x, y - 1, 16)]);
    assert_pattern(&v, PATTERN_CARRIED_ROWS, "rows carried into all following rows by parity");
    memcpy(p->b, p->a, sizeof p->b);
    for (int z = 12; z < 16; z++)
        for (int y = 12; y < 16; y++)
            for (int x = 12; x < 20; x++) { /* the non-cutting part begins at x = 16 in p->a, but at x = 12 in p->b */
                p->b[at(x, y, z)] = 2;
                p->a[at(x, y, z)] = x < 16 ? 1 : 2;
            }
    assert_pattern(&v, PATTERN_TOOL_CLASS, "voxels whose class is not cutting instead of cutting");
    /* The ball contains a non-cutting part. Where a row of the ball is missing, this part is exposed. */
    for (int i = 0; i < N * N * N; i++)
        p->a[i] = p->b[i] = p->a[i] != 0;
    for (int y = 12; y < 14; y++)
        for (int x = 0; x < N; x++)
            p->b[at(x, y, 15)] = x >= 10 && x < 14 ? 2 : 0;
    assert_pattern(&v, PATTERN_COLUMN_PARITY, "empty rows of one mesh that expose another mesh");
    memcpy(p->b, p->a, sizeof p->b);
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 1; x < N; x++)
                if (p->a[at(x, y, z)] && !p->a[at(x - 1, y, z)])
                    p->b[at(x, y, z)] = 0;
    assert_pattern(&v, PATTERN_BOUNDARY_LAYER, "the first voxel of every row missing");
}

/* --------------------------------------------------- known mistakes */

/* Returns the difference class that this mistake causes in a scene, or NULL if nothing differs. */
static const char *class_of(const deviation *how, const scene *s, const trace *ref, finding *f, compare_difference *d)
{
    ost_backend *backend;
    ost_error err = {0};
    trace got;
    assert_ok(dense_open(how, &backend, &err));
    traced(backend, s, "got", &got);
    compare_case(ref, compare_find(ref, 0), &got, compare_find(&got, 0), d);
    const char *class = NULL;
    if (d->kind != COMPARE_EQUAL) {
        finding_make(s, ref, compare_find(ref, 0), &got, compare_find(&got, 0), d, f);
        class = f->class ? f->class : "none";
    }
    trace_free(&got);
    return class;
}

/*
 * Tests each class with a backend that makes a mistake of this class. A difference of only a few voxels may
 * be classified differently; the member `or` lists the other classes that are allowed.
 */
static void classes_of_deliberate_mistakes(void **state)
{
    static const struct {
        deviation_kind kind;
        uint32_t one_in;
        pattern expected;
        const char *or;
    } rows[] = {
        {DEVIATION_BYTE_ORDER, 1, PATTERN_BYTE_ORDER, ""},
        {DEVIATION_SWAPPED_AXIS, 1, PATTERN_AXIS_SWAP, ""},
        {DEVIATION_LAYER_OFF_BY_ONE, 4, PATTERN_SHIFT, ""},
        {DEVIATION_CHUNK_SHIFTED, 1, PATTERN_SHIFT, ""},
        {DEVIATION_PADDED_PITCH, 1, PATTERN_ROW_PITCH, ""},
        {DEVIATION_WRONG_THRESHOLD, 1, PATTERN_THRESHOLD, "speckle"},
        {DEVIATION_INACTIVE_KEPT, 1, PATTERN_THRESHOLD, ""},
        {DEVIATION_STALE_CHUNK, 1, PATTERN_STALE_CHUNK, ""},
        {DEVIATION_LAST_LAYER_LOST, 1, PATTERN_LOST_TAIL, ""},
        {DEVIATION_DROPPED_LAST_ITEMS, 1, PATTERN_LOST_TAIL, "speckle report-only"},
        {DEVIATION_PARTIAL_CHUNKS_LOST, 1, PATTERN_LOST_CHUNK, ""},
        {DEVIATION_TRIANGLES_LOST, 1, PATTERN_COLUMN_PARITY, "unclassified report-only lost-tail speckle"},
        {DEVIATION_UNCLEARED_COUNTS, 1, PATTERN_CARRIED_ROWS, "column-parity unclassified"},
        {DEVIATION_EXCLUDED_CROSSING, 1, PATTERN_BOUNDARY_LAYER, "speckle column-parity unclassified"},
        {DEVIATION_GARBAGE_IN_VOID, 64, PATTERN_SPECKLE, ""},
        {DEVIATION_FLIP_BIT, 1, PATTERN_SPECKLE, "offset boundary-layer threshold"},
        {DEVIATION_CLASS_BORDER, 1, PATTERN_UNCLASSIFIED, "report-only"},
    };
    int seen[sizeof rows / sizeof rows[0]] = {0};
    (void)state;
    for (int number = 0; number < SCENES; number++) {
        scene s;
        trace ref;
        traced_small(number, 7, &s, &ref);
        for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
            const deviation how = {rows[r].kind, (uint64_t)number, rows[r].one_in};
            finding f;
            compare_difference d;
            const char *class = class_of(&how, &s, &ref, &f, &d), *name = deviation_describe(rows[r].kind)->name,
                       *expected = ost_pattern_name(rows[r].expected);
            if (!class)
                continue;
            const bool is = strcmp(class, expected) == 0;
            seen[r] += is || strstr(rows[r].or, class);
            if (!is && !strstr(rows[r].or, class))
                fail_msg("mistake %s in case small/%d: class %s (%s), expected %s", name, number, class, f.text,
                         expected);
            if (d.kind == COMPARE_VOXEL && d.stage != TRACE_FINAL && d.stage != TRACE_UPLOAD && !f.operands.count)
                fail_msg("mistake %s in case small/%d: no operands at %s %u", name, number, trace_stage_name(d.stage),
                         d.item);
            for (int i = 0; i < f.operands.count; i++)
                assert_true(f.operands.lines[i].name[0] && f.operands.lines[i].value[0]);
        }
        trace_free(&ref);
        scene_free(&s);
    }
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++)
        if (!seen[r])
            fail_msg("mistake %s changed no result in any case", deviation_describe(rows[r].kind)->name);
}

static void confusion_table(void **state)
{
    (void)state;
    if (!getenv("OST_TEST_LONG"))
        skip();
    static sensitivity s;
    ost_error err = {0};
    assert_ok(sensitivity_run(3, 3000, 2, NULL, NULL, &s, &err));
    printf("%-24s", "mistake");
    for (int c = 0; c < SENSITIVITY_CLASSES; c++)
        printf(" %.9s", sensitivity_class_name(c));
    printf("\n");
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++) {
        uint64_t sum = 0;
        printf("%-24s", deviation_describe((deviation_kind)k)->name);
        for (int c = 0; c < SENSITIVITY_CLASSES; c++) {
            printf(" %9llu", (unsigned long long)s.classes[k][c]);
            sum += s.classes[k][c];
        }
        printf("\n");
        assert_int_equal(sum, s.of[k].detected);
    }
}

/* Returns the kind of deviation with this name, or DEVIATION_NONE if there is none. */
static deviation_kind kind_by_name(const char *name)
{
    for (int kind = DEVIATION_NONE + 1; kind < DEVIATION_KINDS; kind++)
        if (strcmp(deviation_describe((deviation_kind)kind)->name, name) == 0)
            return (deviation_kind)kind;
    return DEVIATION_NONE;
}

/*
 * Tests the table of causes. Every kind of deviation in it must exist. For each class, the counts
 * of the named kinds must not add up to more than the count of the class. No sentence may state a
 * cause as certain.
 */
static void causes_are_stated_as_possible(void **state)
{
    (void)state;
    int sum = 0;
    for (int c = 0; c < SENSITIVITY_CLASSES; c++) {
        const char *class = sensitivity_class_name(c);
        const causes *one = causes_of(class);
        char text[CAUSES_TEXT];
        causes_text(class, text);
        if (!one) {
            assert_string_equal(text, "");
            continue;
        }
        int named = 0;
        for (int i = 0; i < CAUSES_NAMED && one->most[i].kind; i++) {
            assert_int_not_equal(kind_by_name(one->most[i].kind), DEVIATION_NONE);
            assert_true(i == 0 || one->most[i].mistakes <= one->most[i - 1].mistakes);
            assert_non_null(strstr(text, one->most[i].kind));
            named += one->most[i].mistakes;
        }
        assert_true(named <= one->mistakes);
        assert_int_equal(strncmp(text, "possible causes, by ", 20), 0);
        assert_true(strlen(text) < CAUSES_TEXT - 1);
        sum += one->mistakes;
    }
    assert_int_equal(sum, 2767); /* each mistake that changed a result belongs to exactly one class */
    char text[CAUSES_TEXT];
    causes_text("stale-chunk", text);
    assert_string_equal(text, "possible causes, by 60 known mistakes that look like this: stale-chunk 100 %");
    causes_text(NULL, text);
    assert_string_equal(text, "");
    if (!getenv("OST_TEST_LONG"))
        return;
    /* Computes the table again. Small changes of the scenes may change an entry, so a deviation of 3 percentage
       points is allowed. */
    static sensitivity s;
    ost_error err = {0};
    assert_ok(sensitivity_run(1, sensitivity_injections(PLAN_STANDARD), 2, NULL, NULL, &s, &err));
    for (int c = 0; c < SENSITIVITY_CLASSES; c++) {
        const causes *one = causes_of(sensitivity_class_name(c));
        double all = 0;
        for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++)
            all += (double)s.classes[k][c];
        for (int i = 0; one && i < CAUSES_NAMED && one->most[i].kind; i++) {
            const double was = (double)one->most[i].mistakes / one->mistakes,
                         is = (double)s.classes[kind_by_name(one->most[i].kind)][c] / all;
            assert_true(was - is < 0.03 && is - was < 0.03);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterns_in_hand_made_grids),
        cmocka_unit_test(patterns_of_events),
        cmocka_unit_test(patterns_of_tools),
        cmocka_unit_test(classes_of_deliberate_mistakes),
        cmocka_unit_test(confusion_table),
        cmocka_unit_test(causes_are_stated_as_possible),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
