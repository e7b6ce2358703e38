/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the compared removal methods: each must remove exactly the set of voxels that its definition requires. The
 * oracle of methods_oracle.h is compared with every method in random small scenes, and with the functions that define
 * the sets of a measurement.
 *
 * Covers: REQ-COMPARED
 */
#include "methods_oracle.h"

#include <math.h>

#include "reproduction/methods/device.h"
#include "reproduction/methods/measure.h"

enum { SCENES = 80, THREADS_MAX = 3 };

/* ---------------------------------------------------------------- random scenes */

static double uniform(test_rng *rng)
{
    return (double)rng_range(rng, -1000000, 1000000) * 1e-6;
}

/* Chooses a random unit quaternion. Some are rotations by multiples of 90 degrees. */
static void random_rotation(test_rng *rng, ost_pose *pose)
{
    double q[4], length = 0;
    do {
        length = 0;
        for (int c = 0; c < 4; c++) {
            q[c] = rng_range(rng, 0, 3) == 0 ? (double)rng_range(rng, -1, 1) : uniform(rng);
            length += q[c] * q[c];
        }
    } while (length < 0.01);
    length = sqrt(length);
    pose->qw = (int32_t)lrint(q[0] / length * (1 << 30));
    pose->qx = (int32_t)lrint(q[1] / length * (1 << 30));
    pose->qy = (int32_t)lrint(q[2] / length * (1 << 30));
    pose->qz = (int32_t)lrint(q[3] / length * (1 << 30));
}

/*
 * Makes a tool of random classes. The classes form blobs, so that some cells have a uniform content, and single voxels
 * have other classes.
 */
static void random_tool(test_rng *rng, ost_tool_volume *tool)
{
    const ost_dims d = tool->geometry.dims;
    const int64_t noise = rng_range(rng, 0, 30);
    const double middle[3] = {d.x * 0.5, d.y * 0.5, d.z * 0.5}, radius = (double)rng_range(rng, 1, 14);
    uint8_t *at = tool->voxels;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++) {
                const double x = i + 0.5 - middle[0], y = j + 0.5 - middle[1], z = k + 0.5 - middle[2];
                uint8_t value = x * x + y * y + z * z < radius * radius ? OST_TOOL_CUTTING : OST_TOOL_VOID;
                if (rng_range(rng, 0, 99) < noise)
                    value = (uint8_t)rng_range(rng, 0, 2);
                *at++ = value;
            }
}

static void random_bone(test_rng *rng, methods_scene *scene)
{
    const ost_dims d = scene->event.bone.dims;
    const int64_t holes = rng_range(rng, 0, 3) == 0 ? rng_range(rng, 1, 95) : 0;
    const int32_t void_block = (int32_t)rng_range(rng, 0, 7);
    for (int32_t v = 0; v < d.x * d.y * d.z; v++) {
        const int32_t i = v % d.x, j = v / d.x % d.y, k = v / d.x / d.y;
        const bool in_void = (i / 16 % 2) + 2 * (j / 16 % 2) + 4 * (k / 16 % 2) == void_block;
        const bool active = !in_void && rng_range(rng, 0, 99) >= holes;
        scene->voxels[v] = active ? (int16_t)rng_range(rng, SCENE_THRESHOLD, 2000) : 0;
    }
}

static void random_scene(test_rng *rng, methods_scene *scene)
{
    ost_error err = {0};
    bench_scene *e = &scene->event;
    const ost_pm s = rng_range(rng, OST_PM_PER_MM / 10, OST_PM_PER_MM);
    *scene = (methods_scene){.voxels = NULL};
    *e = (bench_scene){.tool_name = "random", .classes = ost_density_classes_default(), .by_range = true};
    e->bone = (ost_geometry){.dims = {(int32_t)rng_range(rng, 1, 70), (int32_t)rng_range(rng, 1, 40),
                                      (int32_t)rng_range(rng, 1, 40)},
                             .spacing = {s, s, s},
                             .origin = {rng_range(rng, -50, 50) * s, rng_range(rng, -s, s), 0}};
    /* tool voxels of 1/4 to 4 bone voxels; the ratio is usually not an integer */
    const ost_tool_geometry grid = {
        .dims = {(int32_t)rng_range(rng, 1, 30), (int32_t)rng_range(rng, 1, 30), (int32_t)rng_range(rng, 1, 30)},
        .voxel = rng_range(rng, s / 4, rng_range(rng, 0, 2) ? s : 4 * s),
        .corner = {rng_range(rng, -20 * s, 5 * s), rng_range(rng, -20 * s, 5 * s), rng_range(rng, -20 * s, 5 * s)}};
    assert_ok(ost_tool_volume_init(&e->tool, &grid, &err));
    random_tool(rng, &e->tool);
    scene->voxels = malloc((size_t)ost_dims_count(e->bone.dims) * sizeof *scene->voxels);
    assert_non_null(scene->voxels);
    random_bone(rng, scene);
    ost_pose pose = {.t = {e->bone.origin.x + rng_range(rng, -10, e->bone.dims.x + 10) * s,
                           e->bone.origin.y + rng_range(rng, -10, e->bone.dims.y + 10) * s,
                           e->bone.origin.z + rng_range(rng, -10 * s, (e->bone.dims.z + 10) * s)}};
    random_rotation(rng, &pose);
    assert_ok(bench_scene_set_pose(e, &pose, &err));
    methods_scene_set_region(scene);
}

/* ---------------------------------------------------------------------- checks */

/* Returns the value of a set at a voxel of the bone, or 0 outside the set's box. */
static uint8_t set_at(const method_set *set, int32_t i, int32_t j, int32_t k)
{
    const ost_voxel_box *b = &set->box;
    if (i < b->lo[0] || j < b->lo[1] || k < b->lo[2] || i >= b->hi[0] || j >= b->hi[1] || k >= b->hi[2])
        return 0;
    return set->in[method_set_row(set, j, k) + (size_t)(i - b->lo[0])];
}

/* Counts the voxels of the complete bone that are in only one of the two sets. */
static int64_t differences(const methods_scene *scene, const method_set *set, const uint8_t *expected)
{
    const ost_dims d = scene->event.bone.dims;
    int64_t count = 0;
    for (int32_t v = 0; v < d.x * d.y * d.z; v++)
        count += set_at(set, v % d.x, v / d.x % d.y, v / d.x / d.y) != expected[v];
    return count;
}

static void run_event(const method *m, void *state, const methods_scene *scene, method_set *set)
{
    ost_error err = {0};
    assert_ok(m->remove(state, &err));
    assert_ok(method_set_init(set, &scene->region, &err));
    assert_ok(m->result(state, set, &err));
}

/*
 * Processes the event three times: on the original bone, on the resulting bone, and on the restored bone. Each time,
 * exactly the expected voxels of the original bone must be absent afterwards.
 */
static void check_method(const method *m, const methods_scene *scene, const method_setup *setup,
                         const uint8_t *bone_to_tool, const uint8_t *tool_to_bone)
{
    const uint8_t *expected = m->info.definition == METHODS_TOOL_TO_BONE ? tool_to_bone : bone_to_tool;
    ost_error err = {0};
    void *state = NULL;
    ost_status status = method_open(m, scene, setup, &state, &err);
    if (status == OST_ERR_UNAVAILABLE) {
        print_message("# %s: %s\n", m->info.name, err.text);
        return;
    }
    assert_ok(status);
    method_set demanded;
    assert_ok(method_set_init(&demanded, &scene->region, &err));
    method_define_bone_to_tool(&demanded, &scene->event, scene->voxels);
    for (int round = 0; round < 3; round++) {
        method_set set;
        if (round != 1)
            assert_ok(m->restore(state, &err));
        run_event(m, state, scene, &set);
        const int64_t wrong = m->info.definition == METHODS_BONE_TO_TOOL_FLOAT
                                  ? method_beyond_floats(&demanded, &set, &scene->event)
                                  : differences(scene, &set, expected);
        if (wrong)
            fail_msg("%s: %lld voxels differ from the expected set in round %d", m->info.name, (long long)wrong,
                     round);
        method_set_free(&set);
    }
    method_set_free(&demanded);
    m->close(state);
}

static void test_all_methods(void **unused)
{
    (void)unused;
    test_rng rng = rng_seeded("methods");
    char reason[BENCH_TEXT];
    static const int sizes[] = {16, 32, 64};
    int64_t hit = 0;
    struct method_device *device = method_device_open("cl:platform=0,device=0", reason);
    if (!device)
        print_message("# methods on OpenCL are not tested: %s\n", reason);
    for (int n = 0; n < SCENES; n++) {
        methods_scene scene;
        random_scene(&rng, &scene);
        const size_t count = (size_t)ost_dims_count(scene.event.bone.dims);
        uint8_t *bone_to_tool = malloc(count), *tool_to_bone = malloc(count);
        assert_true(bone_to_tool && tool_to_bone);
        const method_setup setup = {.chunk_size = sizes[rng_range(&rng, 0, 2)],
                                    .threads = (int)rng_range(&rng, 1, THREADS_MAX),
                                    .points = (methods_points)rng_range(&rng, 0, 1),
                                    .backend = "cpu", .device = n % 5 == 0 ? device : NULL};
        oracle_bone_to_tool(&scene, bone_to_tool);
        oracle_tool_to_bone(&scene, setup.points, tool_to_bone);
        for (size_t v = 0; v < count; v++)
            hit += bone_to_tool[v] + tool_to_bone[v];
        for (int m = 0; m < methods_count(); m++)
            if (!methods_info_get(m)->device || setup.device)
                check_method(method_get(m), &scene, &setup, bone_to_tool, tool_to_bone);
        free(bone_to_tool);
        free(tool_to_bone);
        methods_scene_free(&scene);
    }
    assert_true(hit > 1000);
    method_device_close(device);
}

static int64_t count_set(const method_set *set)
{
    const size_t count = method_box_count(&set->box);
    int64_t in = 0;
    for (size_t v = 0; v < count; v++)
        in += set->in[v];
    return in;
}

/*
 * The functions that define the sets of a measurement must agree with the oracle, and differences must be counted
 * correctly.
 */
static void test_definitions(void **unused)
{
    (void)unused;
    test_rng rng = rng_seeded("definitions");
    ost_error err = {0};
    for (int n = 0; n < SCENES; n++) {
        methods_scene scene;
        method_points points;
        points_map map;
        method_set own, sampled;
        method_difference d;
        random_scene(&rng, &scene);
        const methods_points which = (methods_points)rng_range(&rng, 0, 1);
        const size_t count = (size_t)ost_dims_count(scene.event.bone.dims);
        uint8_t *expected = malloc(count);
        assert_non_null(expected);
        assert_ok(method_points_init(&points, &scene.event.tool, which, 0, &err));
        assert_ok(points_map_make(&map, &scene.event.pose, &scene.event.bone, &scene.event.tool.geometry, &err));
        assert_ok(method_set_init(&own, &scene.region, &err));
        assert_ok(method_set_init(&sampled, &scene.region, &err));
        method_define_bone_to_tool(&own, &scene.event, scene.voxels);
        method_define_tool_to_bone(&sampled, &points, &map, scene.event.bone.dims, scene.voxels);
        oracle_bone_to_tool(&scene, expected);
        assert_int_equal(differences(&scene, &own, expected), 0);
        oracle_tool_to_bone(&scene, which, expected);
        assert_int_equal(differences(&scene, &sampled, expected), 0);
        method_set_compare(&own, &sampled, &d);
        assert_int_equal(d.expected, count_set(&own));
        assert_int_equal(d.removed, count_set(&sampled));
        assert_int_equal(d.expected - d.missed, d.removed - d.extra);
        assert_true(d.missed_inside <= d.missed);
        method_set_free(&own);
        method_set_free(&sampled);
        method_points_free(&points);
        methods_scene_free(&scene);
        free(expected);
    }
}

/* The comparison with the float map must report a voxel that is wrong for a reason other than rounding. */
static void test_beyond_floats(void **unused)
{
    (void)unused;
    ost_error err = {0};
    bench_scene event;
    method_set right, wrong;
    assert_ok(methods_middle_event(&event, OST_TOOL_REAMER, OST_PM_PER_MM / 2, &err));
    assert_ok(method_set_init(&right, &event.box, &err));
    assert_ok(method_set_init(&wrong, &event.box, &err));
    method_define_bone_to_tool(&right, &event, NULL);
    method_define_bone_to_tool(&wrong, &event, NULL);
    assert_true(count_set(&right) > 10000);
    assert_int_equal(method_beyond_floats(&right, &wrong, &event), 0);
    const size_t count = method_box_count(&event.box);
    for (size_t v = 0; v < count; v++)
        wrong.in[v] ^= v % 100 == 0;
    /* At most a few voxels are so close to a border that floats may give a different result. */
    const int64_t beyond = method_beyond_floats(&right, &wrong, &event);
    assert_in_range(beyond, count / 100 * 99 / 100, count / 100 + 1);
    method_set_free(&right);
    method_set_free(&wrong);
    bench_scene_free(&event);
}

/*
 * Tests which voxels points of the tool miss. The centre of a bone voxel is at most sqrt(3)/2 tool voxels from the
 * centre of the tool voxel that covers it. If this is less than half a bone voxel, the tool voxel's point lies in the
 * bone voxel. Therefore, with all cutting voxels as points, no voxel is missed for ratios below 1/sqrt(3) = 0.577.
 * For large ratios, voxels must be missed, because a set of n points hits at most n voxels.
 */
static void test_sampling(void **unused)
{
    (void)unused;
    static const double ratios[] = {0.25, 0.5, 0.57, 1, 1.5, 2};
    enum { COUNT = sizeof ratios / sizeof ratios[0] };
    ost_error err = {0};
    methods_sample solid[COUNT], surface[COUNT], path[1];
    assert_ok(methods_sampling(OST_TOOL_PEG, METHODS_POINTS_SOLID, 1, ratios, COUNT, solid, &err));
    assert_ok(methods_sampling(OST_TOOL_PEG, METHODS_POINTS_SURFACE, 1, ratios, COUNT, surface, &err));
    for (int n = 0; n < COUNT; n++) {
        if (ratios[n] < 0.577)
            assert_int_equal(solid[n].missed, 0);
        assert_true(solid[n].found + solid[n].extra <= solid[n].tool_points);
        assert_true(surface[n].tool_points < solid[n].tool_points || ratios[n] > 1);
        assert_true(surface[n].missed >= solid[n].missed);
        assert_int_equal(solid[n].found + solid[n].missed, solid[n].expected);
        assert_true(solid[n].missed_inside <= solid[n].missed);
    }
    /* A peg with a diameter of 6 mm and a length of 30 mm covers 8,170 bone voxels of 0.47 mm. */
    assert_in_range(solid[1].expected, 7800, 8500);
    /* At ratio 2, there is one point per eight voxels. */
    assert_true(solid[5].missed_share > 0.8 && solid[5].missed_inside > 0);
    /*
     * The surface points of a static tool do not remove bone inside the tool. A moving tool removes the bone that its
     * surface points pass.
     */
    assert_true(surface[0].missed_inside > surface[0].expected / 5);
    assert_ok(methods_sampling(OST_TOOL_PEG, METHODS_POINTS_SURFACE, 30, ratios, 1, path, &err));
    assert_true(path[0].expected > surface[0].expected);
    assert_true(path[0].missed_share < surface[0].missed_share);
    const double wrong = 5;
    assert_int_equal(methods_sampling(OST_TOOL_PEG, METHODS_POINTS_SOLID, 1, &wrong, 1, solid, &err), OST_ERR_RANGE);
}

static void test_slice(void **unused)
{
    (void)unused;
    ost_error err = {0};
    methods_slice slice;
    int64_t values[METHODS_SLICE_EXTRA + 1] = {0};
    assert_ok(methods_sampling_slice(OST_TOOL_REAMER, METHODS_POINTS_SOLID, 1, 1.5, &slice, &err));
    for (int32_t v = 0; v < slice.width * slice.height; v++) {
        assert_true(slice.values[v] <= METHODS_SLICE_EXTRA);
        values[slice.values[v]]++;
    }
    assert_true(values[METHODS_SLICE_NONE] > 0 && values[METHODS_SLICE_BOTH] > 0 &&
                values[METHODS_SLICE_MISSED_INSIDE] > 0);
    methods_slice_free(&slice);
}

/* With these options, each event is measured once. */
static const methods_options quick = {.backend = "cpu", .threads = 1, .repeat = 1,
                                      .points = METHODS_POINTS_SURFACE};

static void check_rows(const methods_table *table)
{
    for (size_t r = 0; r < table->count; r++) {
        const methods_row *row = &table->rows[r];
        if (row->method->device) {
            assert_true(row->reason[0] != 0);
            continue;
        }
        if (row->reason[0])
            fail_msg("%s: %s", row->method->name, row->reason);
        if (!row->exact)
            fail_msg("%s: the removed set differs from the set that the definition requires", row->method->name);
        assert_true(row->fresh.count == 1 && row->fresh.median > 0 && row->steady.count == 1);
        assert_int_equal(row->expected - row->missed, row->removed - row->extra);
    }
}

static void test_chunk_counts(void **unused)
{
    (void)unused;
    static const int counts[] = {1, 5, 64, 100000};
    ost_error err = {0};
    methods_table table = {.rows = NULL};
    methods_options options = quick;
    options.methods = "osteon,yau,thesis_chunks,octree";
    assert_ok(methods_chunk_counts(&options, OST_TOOL_REAMER, counts, 4, &table, &err));
    assert_int_equal(table.count, 16);
    for (size_t r = 0; r < table.count; r++) {
        assert_int_equal(table.rows[r].chunks, counts[r / 4]);
        assert_true((table.rows[r].reason[0] != 0) == (r >= 12));
    }
    table.count = 12;
    check_rows(&table);
    methods_table_free(&table);
}

static void test_resolutions(void **unused)
{
    (void)unused;
    static const int32_t tools[] = {32, 64}, bones[] = {64, 100};
    ost_error err = {0};
    methods_table table = {.rows = NULL};
    assert_ok(methods_resolutions(&quick, OST_TOOL_REAMER, tools, 2, bones, 2, &table, &err));
    assert_ok(methods_resolutions(&quick, OST_TOOL_PEG, tools, 2, bones, 2, &table, &err));
    assert_int_equal(table.count, 8 * (size_t)methods_count());
    check_rows(&table);
    for (size_t r = 0; r < table.count; r++)
        assert_in_range(table.rows[r].tool_side, tools[r / (size_t)methods_count() % 2] - 5,
                        tools[r / (size_t)methods_count() % 2]);
    methods_table_free(&table);
}

static void test_wrong_use(void **unused)
{
    (void)unused;
    ost_error err = {0};
    static const int32_t side = 32;
    methods_table table = {.rows = NULL};
    methods_options options = quick;
    options.methods = "osteon,yaw";
    assert_int_equal(methods_resolutions(&options, OST_TOOL_REAMER, &side, 1, &side, 1, &table, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "yaw"));
    options = quick;
    options.threads = 0;
    assert_int_equal(methods_chunk_counts(&options, OST_TOOL_REAMER, (const int[]){1}, 1, &table, &err), OST_ERR_USAGE);
    assert_int_equal(table.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_methods),  cmocka_unit_test(test_definitions), cmocka_unit_test(test_beyond_floats),
        cmocka_unit_test(test_sampling),     cmocka_unit_test(test_slice),       cmocka_unit_test(test_chunk_counts),
        cmocka_unit_test(test_resolutions),  cmocka_unit_test(test_wrong_use),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
