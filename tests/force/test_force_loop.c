/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the force loop is stable. The simulated device is held in a light, normal or firm grip. It
 * presses the built-in peg or reamer into bone or drags it along the bone, with and without friction in the
 * device. No combination may oscillate: the RMS deviation of the speed from its own mean must stay below
 * 10 mm/s. A limit cycle exceeds this bound. Further tests check that the loop oscillates if the stiffness is eight
 * times as high, and that the same operation removes more bone without a force.
 *
 * OST_TEST_LONG=1 adds the burr, the instant law, and all grips without friction.
 *
 *   OST_FORCE_CSV=FOLDER   adds the burr, and writes each run as tool-way-law-grip-friction.csv
 *                          with the time, the hand's target for the device, the device's position
 *                          and the force
 * Covers: REQ-FORCE-STABLE
 */
#include "ref/scene.h"

#include <math.h>

#include <osteon/operation.h>
#include <osteon/phantom.h>

#define MM OST_PM_PER_MM

enum { REACH_MS = 400, HOLD_MS = 1600, TICKS = REACH_MS + HOLD_MS };

typedef struct run {
    ost_operation *operation;
    double z[TICKS], x[TICKS], force[TICKS];
    size_t count;
} run;

static ost_tool *builtin_tool(ost_backend *backend, ost_tool_kind kind)
{
    ost_error err = {0};
    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    ost_tool_geometry grid;
    ost_snapped_mesh snapped;
    ost_tool *tool;
    assert_ok(ost_tool_make(kind, NULL, &mesh, &err));
    assert_ok(ost_mesh_bounds(&mesh, &lo, &hi, &err));
    assert_ok(ost_tool_geometry_from_bounds(lo, hi, MM / 2, &grid, &err));
    assert_ok(ost_mesh_snap(&mesh, &grid, &snapped, &err));
    assert_ok(ost_voxelize(backend, &snapped, NULL, OST_FILL_WINDING, NULL, &tool, &err));
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    return tool;
}

/* Makes a block of bone, 60 x 60 x 20 mm in size, with 0.5 mm voxels of 800 HU. Its upper face is at z = 0. */
static ost_bone *block(ost_backend *backend)
{
    const ost_geometry g = cubic_geometry(120, 120, 40, MM / 2,
                                          (ost_pm3){-30 * MM + MM / 4, -30 * MM + MM / 4, -20 * MM + MM / 4});
    int16_t *voxels = malloc(voxel_count(&g) * sizeof *voxels);
    assert_non_null(voxels);
    for (size_t i = 0; i < voxel_count(&g); i++)
        voxels[i] = 800;
    ost_bone *bone = bone_of(backend, &g, 32, voxels);
    free(voxels);
    return bone;
}

/* Returns a path from 3 mm above the bone to 5 mm inside the bone. There the tool is held still or dragged 6 mm along
   x. */
static ost_path plan(double lowest_mm, bool drag)
{
    ost_error err = {0};
    ost_path path;
    assert_ok(ost_path_init(&path, TICKS, &err));
    for (int i = 0; i < TICKS; i++) {
        const double down = i < REACH_MS ? 3 - 8.0 * i / REACH_MS : -5,
                     along = drag && i > REACH_MS ? 6.0 * (i - REACH_MS) / HOLD_MS : 0;
        path.ticks[i] = (ost_tick){
            .t_ns = (int64_t)i * 1000000,
            .rpm = OST_RPM_ON,
            .pose = {.t = {(ost_pm)(along * 1e9), 0, (ost_pm)((down - lowest_mm) * 1e9)}, .qw = OST_Q30_ONE}};
    }
    return path;
}

static bool tick_and_record(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    run *r = user;
    const bool more = ost_operation_tick(r->operation, sample, wrench);
    if (r->count < TICKS) {
        r->x[r->count] = (double)sample->state.pose.t.x * 1e-12;
        r->z[r->count] = (double)sample->state.pose.t.z * 1e-12;
        r->force[r->count++] = wrench->force_n[2];
    }
    return more;
}

static void tick_done(void *user, uint64_t number, uint32_t exec_ns)
{
    ost_operation_done(((run *)user)->operation, number, exec_ns);
}

/*
 * Returns the RMS difference in mm/s between the speed averaged over 10 ms and the speed averaged
 * over 200 ms, during the last 0.8 s. One encoder step in 10 ms is a speed of 5.5 mm/s. If a held
 * device oscillates, its frequency is 5 to 40 Hz.
 */
static double speed_deviation(const double at[])
{
    enum { LAST = 800, SHORT = 5, LONG = 100 };
    double sum = 0;
    for (int i = TICKS - LAST; i < TICKS - LONG; i++) {
        const double speed = (at[i + SHORT] - at[i - SHORT]) / (2 * SHORT) * 1e3,
                     mean = (at[i + LONG] - at[i - LONG]) / (2 * LONG) * 1e3;
        sum += (speed - mean) * (speed - mean);
    }
    return sqrt(sum / (LAST - LONG)) * 1e3;
}

static void write_csv(const char *name, const ost_path *path, const run *r)
{
    const char *folder = getenv("OST_FORCE_CSV");
    char file[600];
    if (!folder)
        return;
    snprintf(file, sizeof file, "%s/%s.csv", folder, name);
    FILE *out = fopen(file, "w");
    assert_non_null(out);
    fprintf(out, "t_s,hand_x_mm,hand_z_mm,device_x_mm,device_z_mm,force_z_n\n");
    for (size_t i = 0; i < r->count; i++)
        fprintf(out, "%.3f,%.4f,%.4f,%.4f,%.4f,%.4f\n", (double)i * 1e-3, (double)path->ticks[i].pose.t.x * 1e-9,
                (double)path->ticks[i].pose.t.z * 1e-9, r->x[i] * 1e3, r->z[i] * 1e3, r->force[i]);
    fclose(out);
}

/* Runs an operation and returns the number of removed voxels. */
static uint64_t operate(ost_backend *backend, ost_tool *tool, const char *device, const ost_path *path,
                        const ost_force_params *params, const ost_safety_params *safety, const char *name, run *r)
{
    ost_error err = {0};
    static ost_servo_report report;
    ost_bone *bone = block(backend);
    ost_world *world;
    ost_haptic *haptic;
    ost_force *force = NULL;
    assert_ok(ost_world_create(bone, NULL, &world, &err));
    assert_ok(ost_world_add_tool(world, "tool", tool, NULL, &err));
    if (params) {
        assert_ok(ost_force_create(bone, params, &force, &err));
        assert_ok(ost_force_add_tool(force, tool, &err));
    }
    assert_ok(ost_haptic_open(device, &(ost_haptic_setup){.path = path}, &haptic, &err));
    *r = (run){0};
    assert_ok(
        ost_operation_create(world, &(ost_operation_options){.force = force, .safety = safety}, &r->operation, &err));
    assert_ok(ost_servo_run(haptic, &(ost_servo_options){.ticks = TICKS, .no_clock = true, .no_realtime = true},
                            tick_and_record, tick_done, r, &report, &err));
    ost_operation_report done;
    ost_operation_report_get(r->operation, &done);
    assert_int_equal(done.faults, 0);
    assert_int_equal(done.steps, TICKS);
    ost_world_totals totals;
    ost_world_totals_get(world, &totals);
    write_csv(name, path, r);
    ost_operation_free(r->operation);
    ost_haptic_close(haptic);
    ost_force_free(force);
    ost_world_free(world);
    ost_bone_free(bone);
    return totals.removed_voxels;
}

static double lowest_mm(const ost_tool *tool)
{
    return ost_pm_to_mm(ost_tool_geometry_get(tool)->corner.z + ost_tool_geometry_get(tool)->voxel);
}

static void force_loop_is_stable(void **state)
{
    static const char *const grips[] = {"light", "normal", "firm"}, *const ways[] = {"press", "drag"},
                             *const modes[] = {"energy", "instant"};
    static const struct {
        const char *name;
        ost_tool_kind kind;
    } tools[] = {{"peg", OST_TOOL_PEG}, {"reamer", OST_TOOL_REAMER}, {"burr", OST_TOOL_BURR}};
    static run r;
    double worst = 0;
    int unstable = 0;
    const char *lengthy = getenv("OST_TEST_LONG");
    const bool all = lengthy && strcmp(lengthy, "1") == 0;
    const int tool_count = all || getenv("OST_FORCE_CSV") ? 3 : 2;
    for (int t = 0; t < tool_count; t++) {
        ost_tool *tool = builtin_tool(*state, tools[t].kind);
        for (int k = 0; k < 24; k++) {
            const int grip = k % 3, drag = k / 3 % 2, mode = k / 6 % 2, friction = k / 12;
            /*
             * Every real device has friction, so all grips are tested with friction. Without
             * friction, only the least stable grip is tested.
             */
            if (!all && (mode || (!friction && grip)))
                continue;
            char device[80], name[120];
            ost_force_params params = ost_force_defaults();
            params.mode = mode ? OST_FORCE_INSTANT : OST_FORCE_ENERGY;
            snprintf(device, sizeof device, "sim:grip=%s,friction=%d", grips[grip], friction ? 260 : 0);
            snprintf(name, sizeof name, "%s-%s-%s-%s-friction%d", tools[t].name, ways[drag], modes[mode], grips[grip],
                     friction ? 260 : 0);
            ost_path path = plan(lowest_mm(tool), drag);
            operate(*state, tool, device, &path, &params, NULL, name, &r);
            const double along = speed_deviation(r.x), down = speed_deviation(r.z);
            print_message("%-42s speed deviation %5.2f mm/s along x, %5.2f mm/s along z; force %5.2f N at the end\n",
                          name, along, down, r.force[TICKS - 1]);
            worst = fmax(worst, fmax(along, down));
            unstable += along >= 10 || down >= 10;
            assert_true(r.force[TICKS - 1] > -0.5 && r.force[TICKS - 1] <= 3);
            ost_path_free(&path);
        }
        ost_tool_free(tool);
    }
    print_message("greatest speed deviation: %.2f mm/s\n", worst);
    assert_int_equal(unstable, 0);
}

/* Checks that speed_deviation() and its bound of 10 mm/s detect an oscillation. */
static void excessive_stiffness_oscillates(void **state)
{
    static run r;
    ost_tool *tool = builtin_tool(*state, OST_TOOL_PEG);
    ost_path path = plan(lowest_mm(tool), false);
    ost_force_params params = ost_force_defaults();
    params.stiffness = 2500;
    params.damping = 0;
    params.speed = 0;
    ost_safety_params bare = ost_safety_defaults();
    bare.max_damping = 0;
    operate(*state, tool, "sim:grip=light,friction=0", &path, &params, &bare, "too-stiff", &r);
    print_message("speed deviation with eight times the stiffness, without damping and passivity control: %.1f mm/s\n",
                  speed_deviation(r.z));
    assert_true(speed_deviation(r.z) > 10);
    ost_path_free(&path);
    ost_tool_free(tool);
}

/* Because bone resists cutting, the force reduces the number of removed voxels. */
static void force_reduces_the_removal(void **state)
{
    static run r;
    ost_tool *tool = builtin_tool(*state, OST_TOOL_PEG);
    ost_path path = plan(lowest_mm(tool), false);
    const ost_force_params params = ost_force_defaults();
    const uint64_t free_hand = operate(*state, tool, "sim", &path, NULL, NULL, "free", &r);
    assert_true(r.force[TICKS - 1] == 0);
    const uint64_t resisted = operate(*state, tool, "sim", &path, &params, NULL, "resisted", &r);
    print_message("voxels removed: %llu without force, %llu with force\n", (unsigned long long)free_hand,
                  (unsigned long long)resisted);
    assert_true(resisted > 0 && resisted < free_hand * 9 / 10);
    assert_true(r.force[TICKS - 1] > 0.1);
    ost_path_free(&path);
    ost_tool_free(tool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_loop_is_stable),
        cmocka_unit_test(excessive_stiffness_oscillates),
        cmocka_unit_test(force_reduces_the_removal),
    };
    /* Forces do not depend on the backend, so one backend is sufficient. */
    snprintf(test_backend, sizeof test_backend, "cpu:threads=1");
    return cmocka_run_group_tests(tests, open_test_backend, close_test_backend);
}
