/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the second implementation of the steps that precede the computation of voxels: the examples
 * of docs/spec/arithmetic.md, wide integers compared with __int128, digests of bones, and the
 * differences that a comparison with this implementation reports.
 *
 * Covers: AR-INT-1, AR-INT-2, AR-POSE-4, AR-CUB-1, AR-TOOL-2, AR-MESH-3, AR-MESH-4, AR-SWEEP-1..5,
 * AR-MAP-1..5, AR-MOTOR-2..7, AR-REM-7, AR-DIG-2..5
 */
#include "harness.h"

#include <unistd.h>

#include "core/int128.h"
#include "io/scratch_group.h"
#include "validation/compare.h"
#include "validation/dense/dense.h"
#include "validation/dense/steps.h"
#include "validation/perform.h"
#include "validation/steps_record.h"

#define UM INT64_C(1000000)

static ost_i128 value_of(wide a)
{
    uint64_t words[2];
    wide_to_words(a, words);
    return (ost_i128)(int64_t)words[1] * ((ost_i128)1 << 64) + (ost_i128)words[0];
}

static void wide_integers(void **state)
{
    (void)state;
    static const int64_t halves[][3] = {{5, 2, 2},   {7, 2, 4},  {-5, 2, -2},
                                        {-7, 2, -4}, {-1, 3, 0}, {-2, 3, -1}}; /* the example of AR-INT-2 */
    test_rng rng = rng_seeded("wide integers");
    for (size_t i = 0; i < sizeof halves / sizeof halves[0]; i++)
        assert_int_equal(wide_to_int64(wide_nearest(wide_of(halves[i][0]), wide_of(halves[i][1]))), halves[i][2]);
    assert_int_equal(wide_to_int64(wide_floor(wide_of(-7), wide_of(2))), -4);
    for (int i = 0; i < 20000; i++) {
        const int64_t a = (int64_t)rng_next(&rng) >> rng_next(&rng) % 64,
                      b = (int64_t)rng_next(&rng) >> (1 + rng_next(&rng) % 63);
        const ost_i128 p = (ost_i128)a * b, by = (ost_i128)(b < 0 ? -b : b) + 1;
        const wide n = wide_times(wide_of(a), wide_of(b)), d = wide_of((int64_t)by);
        assert_true(value_of(n) == p);
        assert_true(value_of(wide_plus(n, wide_of(a))) == p + a && value_of(wide_minus(n, wide_of(a))) == p - a);
        assert_true(value_of(wide_floor(wide_plus(n, wide_of(b)), d)) == ost_floor_div128(p + b, by));
        assert_true(value_of(wide_nearest(n, d)) == ost_rhe_div128(p, by));
        assert_int_equal(wide_order(n, wide_of(a)), p < a ? -1 : p > a);
    }
}

static ost_i128 decimal(const char *text)
{
    const bool negative = *text == '-';
    ost_i128 v = 0;
    for (text += negative; *text; text++)
        v = 10 * v + (*text - '0');
    return negative ? -v : v;
}

/* Tests the example of docs/spec/arithmetic.md, section 12. */
static void map_of_the_specification(void **state)
{
    (void)state;
    static const char *const origin[] = {"34000796832371564562559795200000000", "-34762661917118460467698728960000000",
                                         "-90108978398322049941535457280000000"};
    static const char *const column[3][3] = {
        {"159094637945952872326758400000000", "0", "545467329344448482236170240000000"},
        {"0", "568195134795537347237642240000000", "0"},
        {"-545467329344448482236170240000000", "0", "159094637945952872326758400000000"}};
    static const int32_t step[3][3] = {{275985, 0, 946235}, {0, 985661, 0}, {-946235, 0, 275985}};
    const ost_geometry bone = {{256, 234, 428}, {470 * UM, 470 * UM, 470 * UM}, {-57340 * UM, -54755 * UM, 0}};
    const ost_tool_geometry tool = {{73, 74, 43}, 500 * UM, {-18500 * UM, -18500 * UM, -500 * UM}};
    const ost_pose pose = {{12000 * UM, -7500 * UM, 30250 * UM}, 858993459, 0, 644245094, 0};
    ost_map map;
    int32_t base[3];
    steps_map(&pose, &bone, &tool, &map);
    assert_true(ost_i128_of(map.divisor) == decimal("576460751873926758500000000"));
    for (int a = 0; a < 3; a++) {
        assert_true(ost_i128_of(map.origin[a]) == decimal(origin[a]));
        for (int b = 0; b < 3; b++) {
            assert_true(ost_i128_of(map.column[b][a]) == decimal(column[b][a]));
            assert_int_equal(map.step[b][a], step[b][a]);
        }
    }
    assert_true(steps_block_base(&map, (const int32_t[]){144, 96, 64}, base));
    assert_int_equal(base[0], 38164811);
    assert_int_equal(base[1], 34319892);
    assert_int_equal(base[2], -2393270);
    /*
     * The voxel of the example is inside the tool's grid. Therefore it must also be within the computed
     * bounds.
     */
    ost_voxel_box box;
    assert_true(steps_bounds(&pose, &bone, &tool, &box) && steps_reaches(&map, &bone, &tool, &box));
    const int32_t voxel[3] = {149, 103, 75};
    for (int a = 0; a < 3; a++)
        assert_true(box.lo[a] <= voxel[a] && voxel[a] < box.hi[a]);
}

/* Tests the examples of docs/spec/arithmetic.md, section 11. */
static void sweep_and_motor_of_the_specification(void **state)
{
    (void)state;
    const ost_tool_geometry tool = {{4, 4, 4}, 500 * UM, {-1000 * UM, -1000 * UM, -1000 * UM}};
    const ost_pose a = {{0, 0, 0}, OST_Q30_ONE, 0, 0, 0}, b = {{300 * UM, 400 * UM, 0}, OST_Q30_ONE, 0, 0, 0};
    assert_int_equal(steps_sweep_count(&a, &b, &tool, 470 * UM), 3);
    assert_int_equal(steps_sweep_count(&a, &a, &tool, 470 * UM), 1);
    const ost_pose first = steps_sweep_pose(&a, &b, 1, 3);
    assert_int_equal(first.t.x, 100000000);
    assert_int_equal(first.t.y, 133333333);
    /*
     * The first motion is exactly 4 times half the spacing, so 4 poses are sufficient. The second motion is one
     * picometre longer, so 5 poses are necessary.
     */
    const ost_pose exact = {{2 * 470 * UM, 0, 0}, OST_Q30_ONE, 0, 0, 0},
                   more = {{2 * 470 * UM + 1, 0, 0}, OST_Q30_ONE, 0, 0, 0};
    assert_int_equal(steps_sweep_count(&a, &exact, &tool, 470 * UM), 4);
    assert_int_equal(steps_sweep_count(&a, &more, &tool, 470 * UM), 5);
    const ost_pose far = {{8000 * 1000 * UM, 0, 0}, OST_Q30_ONE, 0, 0, 0},
                   over = {{0, 0, 0}, 759250000, 0, 0, 759250700};
    assert_int_equal(steps_sweep_count(&a, &far, &tool, 470 * UM), 0);
    assert_int_equal(steps_sweep_count(&a, &over, &tool, 470 * UM), 0);

    enum { ROWS = 301 };
    ost_error err = {0};
    ost_path rows, out;
    assert_ok(ost_path_init(&rows, ROWS, &err));
    for (int i = 0; i < ROWS; i++)
        rows.ticks[i] = (ost_tick){.t_ns = 1000000 * (int64_t)i, .rpm = OST_RPM_OF_DEVICE, .pose = a};
    assert_ok(steps_motor_path(&rows, 200, &out, &err));
    assert_int_equal(out.count, ROWS);
    assert_int_equal(out.ticks[1].pose.qw, 1073688450);
    assert_int_equal(out.ticks[1].pose.qz, -10705968);
    assert_int_equal(out.ticks[300].pose.qw, OST_Q30_ONE);
    assert_int_equal(out.ticks[300].pose.qz, 0);
    ost_path_free(&out);
    rows.count = 2;
    rows.ticks[1].t_ns = 100000000;
    assert_ok(steps_motor_path(&rows, 200, &out, &err));
    assert_int_equal(out.count, 4);
    assert_int_equal(out.ticks[1].t_ns, 33333333);
    assert_int_equal(out.ticks[2].t_ns, 66666666);
    ost_path_free(&out);
    ost_path_free(&rows);
}

/* Checks the table of section 9 and the example of the cube, both of docs/spec/arithmetic.md. */
static void grid_of_the_specification(void **state)
{
    (void)state;
    static const struct {
        int64_t voxel_um, corner_um[3];
        int32_t dims[3];
    } of[] = {{1000, {-19000, -19000, -1000}, {38, 38, 23}},
              {750, {-18750, -18750, -750}, {50, 50, 30}},
              {500, {-18500, -18500, -500}, {73, 74, 43}}};
    ost_error err = {0};
    ost_pm3 vertices[3] = {{-18000 * UM, -18000 * UM, 0}, {17400 * UM, 18000 * UM, 0}, {0, 0, 20300 * UM}};
    uint32_t triangles[2][3] = {{0, 1, 2}, {0, 1, 1}};
    const ost_mesh meshes[2] = {{.vertex_count = 3, .vertices = vertices, .triangle_count = 2, .triangles = triangles},
                                {.vertex_count = 0}};
    ost_tool_geometry grid;
    for (size_t i = 0; i < sizeof of / sizeof of[0]; i++) {
        assert_true(steps_tool_grid(meshes, of[i].voxel_um * UM, &grid));
        assert_int_equal(grid.corner.x, of[i].corner_um[0] * UM);
        assert_int_equal(grid.corner.y, of[i].corner_um[1] * UM);
        assert_int_equal(grid.corner.z, of[i].corner_um[2] * UM);
        assert_memory_equal(&grid.dims, of[i].dims, sizeof of[i].dims);
    }
    ost_pm3 corners[2] = {{0, 0, 0}, {1000 * UM, 1000 * UM, 1000 * UM}};
    uint32_t thin[1][3] = {{0, 1, 1}};
    const ost_mesh cube[2] = {{.vertex_count = 2, .vertices = corners, .triangle_count = 1, .triangles = thin},
                              {.vertex_count = 0}};
    ost_snapped_mesh snapped;
    assert_true(steps_tool_grid(cube, 500 * UM, &grid));
    assert_ok(steps_snap(&cube[0], &grid, &snapped, &err));
    assert_int_equal(snapped.fraction_bits, 10);
    assert_int_equal(snapped.vertices[0][0], 1024);
    assert_int_equal(snapped.vertices[1][2], 3072);
    assert_int_equal(snapped.triangle_count, 0);
    assert_int_equal(snapped.dropped_triangles, 1);
    ost_snapped_mesh_free(&snapped);

    /* AR-CUB-1's example: 201 layers of 1 mm become voxels of 0.47 mm. */
    const ost_geometry rect = {{256, 234, 201}, {470 * UM, 470 * UM, 1000 * UM}, {0, 0, 0}},
                       cubic = steps_cubic(&rect, 470 * UM);
    assert_int_equal(cubic.dims.z, 428);
    assert_int_equal(cubic.origin.z, -265 * UM);
    assert_int_equal(cubic.dims.x, 256);
}

/* Checks AR-REM-7, AR-MOTOR-5 and AR-MOTOR-6 against results computed by hand. */
static void events_equal_hand_computed_results(void **state)
{
    (void)state;
    const ost_tool_geometry tool = {{4, 4, 4}, 500 * UM, {-1000 * UM, -1000 * UM, -1000 * UM}};
    const ost_pose at = {{0, 0, 0}, OST_Q30_ONE, 0, 0, 0};
    ost_tick ticks[] = {
        {.t_ns = 0, .rpm = 200, .pose = at},         /* the first tick of its tool */
        {.t_ns = 1000000, .rpm = 200, .pose = at},   /* in the same removal period as the first tick */
        {.t_ns = 3000000, .rpm = 0, .pose = at},     /* motor off: no removal */
        {.t_ns = 3500000, .rpm = 200, .pose = at},   /* the first tick after the motor was off */
        {.t_ns = 3600000, .rpm = 200, .pose = at, .lifted = true},
        {.t_ns = 6000000, .rpm = 200, .pose = at},   /* in the next removal period */
        /* since the last event the tool has turned by a third of a revolution, so the tick is refused */
        {.t_ns = 106000000, .rpm = 200, .pose = at},
        {.t_ns = 46000000, .rpm = 200, .pose = at, .tool = 1},
    };
    static const int events[] = {1, 0, 0, 1, 1, 1, 2, 1};
    ost_error err = {0};
    steps_history h;
    assert_ok(steps_history_begin(&(const ost_path){.ticks = ticks, .count = 8}, false, 3000000, &h, &err));
    for (size_t i = 0; i < sizeof events / sizeof events[0]; i++) {
        const steps_event e = steps_next(&h, i, &tool, 470 * UM);
        assert_int_equal(e.refused ? 2 : e.removal, events[i]);
    }
    steps_history_free(&h);
}

/* Changes one word in one of the two traces of a case. The comparison must return the name of this word. */
static void differing_word_is_named(void **state)
{
    (void)state;
    char paths[2][4200];
    snprintf(paths[0], sizeof paths[0], "%s/by-core", folder);
    snprintf(paths[1], sizeof paths[1], "%s/by-second", folder);
    const plan_case c = {.family = PLAN_STEPS, .number = 2, .tier = PLAN_SMOKE, .seed = 1, .id = "steps/2"};
    ost_error err = {0}, why = {0};
    ost_backend *dense;
    scene s;
    trace_writer *w;
    trace t[2];
    assert_ok(dense_open(NULL, &dense, &err));
    assert_ok(scene_make(&c, &s, &err));
    assert_true(s.handle_path.count > 0 && !s.sample_count);
    for (int second = 0; second < 2; second++) {
        assert_ok(trace_create(paths[second], &w, &err));
        if (second)
            /* the second implementation rotates the rows of the path itself, so it does not use this tick */
            s.path.ticks[5].pose.t.x++;
        assert_ok(second ? perform_second(dense, &s, 0, w, &why, &err)
                         : perform(dense, &s, 0, w, NULL, NULL, &why, &err));
        assert_ok(trace_close(w, &err));
        assert_ok(trace_open(paths[second], &t[second], &err));
    }
    compare_difference d;
    compare_case(&t[0], compare_find(&t[0], 0), &t[1], compare_find(&t[1], 0), &d);
    assert_int_equal(d.kind, COMPARE_EQUAL);
    assert_true(d.records > 20);

    assert_ok(trace_create(paths[0], &w, &err));
    trace_free(&t[0]);
    /* The case is performed with the changed tick, as if src/core had rotated the row of the path in this way. */
    assert_ok(perform(dense, &s, 0, w, NULL, NULL, &why, &err));
    assert_ok(trace_close(w, &err));
    assert_ok(trace_open(paths[0], &t[0], &err));
    compare_case(&t[0], compare_find(&t[0], 0), &t[1], compare_find(&t[1], 0), &d);
    char name[TRACE_WORD];
    assert_int_equal(d.kind, COMPARE_WORD);
    assert_int_equal(d.stage, TRACE_STEPS);
    assert_int_equal(d.item, 5);
    assert_string_equal(trace_word_name(d.stage, d.word, 0, name), "pose x");
    for (int i = 0; i < 2; i++)
        trace_free(&t[i]);
    scene_free(&s);
    ost_backend_close(dense);
}

/* The box of a pose may be larger than necessary. If the pose reaches no voxel, any box is allowed. */
static void larger_boxes_are_accepted(void **state)
{
    (void)state;
    enum { TICK = 11, REACHES = TICK + 54, WORDS = TICK + 61 };
    uint64_t is[WORDS] = {0}, least[WORDS] = {0};
    const uint8_t *a = (const uint8_t *)is, *b = (const uint8_t *)least;
    char name[TRACE_WORD];
    assert_string_equal(trace_word_name(TRACE_STEPS, REACHES, 0, name), "whether it reaches (pose 1)");
    assert_false(trace_word_is_bound(TRACE_STEPS, REACHES - 1));
    is[REACHES] = 1;
    is[REACHES + 1] = 3;
    is[REACHES + 4] = 9;
    /* the flag may be set although the pose reaches no voxel */
    assert_true(trace_word_holds(TRACE_STEPS, REACHES, a, b));
    least[REACHES] = 1;
    least[REACHES + 1] = 3;
    least[REACHES + 4] = 9;
    assert_true(trace_word_holds(TRACE_STEPS, REACHES + 1, a, b) && trace_word_holds(TRACE_STEPS, REACHES + 4, a, b));
    is[REACHES + 1] = 4; /* the box begins one voxel too late */
    is[REACHES + 4] = 8; /* the box ends one voxel too early */
    assert_false(trace_word_holds(TRACE_STEPS, REACHES + 1, a, b) || trace_word_holds(TRACE_STEPS, REACHES + 4, a, b));
    is[REACHES] = 0; /* the box is omitted although voxels are reached */
    assert_false(trace_word_holds(TRACE_STEPS, REACHES, a, b));

    /* Indices of three words of a tick: the flag that states whether boxes meet, and the start and the end of the
       range of chunks along y. */
    enum { MEET = 2, FIRST_Y = 6, END_Y = 7 };
    uint64_t has[13] = {0}, needs[13] = {0};
    const uint8_t *x = (const uint8_t *)has, *y = (const uint8_t *)needs;
    needs[FIRST_Y] = INT32_MAX; /* in the second implementation the event reaches no chunk */
    assert_true(trace_word_holds(TRACE_TICK, MEET, x, y) && trace_word_holds(TRACE_TICK, FIRST_Y, x, y) &&
                trace_word_holds(TRACE_TICK, END_Y, x, y));
    has[MEET] = needs[MEET] = 1;
    has[FIRST_Y] = (uint64_t)-1; /* larger than necessary */
    has[END_Y] = 5;
    needs[FIRST_Y] = 0;
    needs[END_Y] = 4;
    assert_true(trace_word_holds(TRACE_TICK, FIRST_Y, x, y) && trace_word_holds(TRACE_TICK, END_Y, x, y));
    has[MEET] = 0;
    has[FIRST_Y] = 1;
    has[END_Y] = 3;
    assert_false(trace_word_holds(TRACE_TICK, MEET, x, y) || trace_word_holds(TRACE_TICK, FIRST_Y, x, y) ||
                 trace_word_holds(TRACE_TICK, END_Y, x, y));
}

/* Tests the bone of AR-DIG's example and bones of random dims. The library must compute the same digests. */
static void digests_of_bones(void **state)
{
    enum { MOST = 97 };
    static int16_t voxels[MOST * MOST * MOST];
    const ost_geometry example = {{33, 1, 1}, {470 * UM, 470 * UM, 470 * UM}, {-57340 * UM, 0, 0}};
    char hex[OST_DIGEST_HEX];
    ost_digest digest, right;
    ost_error err = {0};
    (void)state;
    test_rng rng = rng_seeded("digests of bones");
    voxels[0] = 120;
    voxels[32] = 1000;
    assert_ok(steps_bone_digest(&example, 120, voxels, &digest, &err));
    assert_string_equal(ost_digest_hex(&digest, hex),
                        "08722c4b6c9d76cb5d1320756f78c1bafa96e2e0e8fd360569a8c8dc92935ed4");
    for (int i = 0; i < 12; i++) {
        const int32_t last[3] = {(int32_t)(rng_next(&rng) % 3) - 1, (int32_t)(rng_next(&rng) % 3) - 1,
                                 (int32_t)(rng_next(&rng) % 3) - 1};
        ost_geometry g = {{32 + last[0], 64 + last[1], 32 * (1 + i % 3) + last[2]}, {7, 8, 9}, {-1, -2, -3}};
        for (int64_t v = 0; v < ost_dims_count(g.dims); v++)
            voxels[v] = (int16_t)rng_next(&rng);
        assert_ok(steps_bone_digest(&g, 0, voxels, &digest, &err));
        assert_ok(ost_digest_dense(OST_GRID_BONE, &g, voxels, sizeof voxels[0], &right, &err));
        assert_true(ost_digest_equal(&digest, &right));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wide_integers),
        cmocka_unit_test(map_of_the_specification),
        cmocka_unit_test(sweep_and_motor_of_the_specification),
        cmocka_unit_test(grid_of_the_specification),
        cmocka_unit_test(events_equal_hand_computed_results),
        cmocka_unit_test(differing_word_is_named),
        cmocka_unit_test(larger_boxes_are_accepted),
        cmocka_unit_test(digests_of_bones),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
