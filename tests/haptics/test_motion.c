/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests recorded motions of a hand as a device: poses between two rows, the tool's pose during
 * and after drop-outs, and invalid files. The motions are generated here, so every pose is
 * given by a formula.
 */
#include "ref/scene.h"

#include <math.h>
#include <zlib.h>

#include <osteon/operation.h>

#include "haptics/driver.h"
#include "io/io_scratch.h"

#define MM OST_PM_PER_MM
enum { ROW_US = 3500, ROWS = 400 };

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = scratch_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    scratch_remove(folder);
    return 0;
}

/*
 * Returns true if the body is tracked in this row. The body moves at 0.2 m/s along (0, 1, 0) and
 * rotates about (0, 0, 1) at 2 rad/s; it starts at (5, 6, 7), rotated by a quarter turn about x. It
 * is not tracked before row 20, in rows 120 to 219, and in the last 10 rows. The rows between 300
 * and 330 are missing in the file.
 */
static bool is_tracked(int row)
{
    return row >= 20 && row < ROWS - 10 && !(row >= 120 && row < 220);
}

static double row_time(int row)
{
    return row * ROW_US * 1e-6;
}

static void body_at(double t, double at[3], double q[4])
{
    const double c = sqrt(0.5), half = t; /* 2 rad/s */
    at[0] = 5;
    at[1] = 6 + 0.2 * t;
    at[2] = 7;
    q[0] = cos(half) * c;
    q[1] = cos(half) * c;
    q[2] = sin(half) * c;
    q[3] = sin(half) * c;
}

static size_t write_motion(char *text, size_t capacity)
{
    size_t used = (size_t)snprintf(text, capacity, "t_s,x_m,y_m,z_m,qw,qx,qy,qz,movement\n");
    for (int row = 0; row < ROWS; row++) {
        double at[3], q[4];
        body_at(row_time(row), at, q);
        if (row > 300 && row < 330)
            continue;
        used += (size_t)snprintf(text + used, capacity - used, "%.4f,%.6f,%.6f,%.6f,", row_time(row), at[0], at[1],
                                 at[2]);
        if (is_tracked(row))
            used += (size_t)snprintf(text + used, capacity - used, "%.8f,%.8f,%.8f,%.8f,1\n", q[0], q[1], q[2], q[3]);
        else
            used += (size_t)snprintf(text + used, capacity - used, "nan,nan,NaN,nan,0\n");
    }
    return used;
}

static ost_haptic *open_motion(const char *file, const char *options, const ost_pose *start)
{
    char spec[4300];
    ost_error err = {0};
    ost_haptic *device;
    snprintf(spec, sizeof spec, "motion:%s%s", file, options);
    assert_ok(ost_haptic_open(spec, &(ost_haptic_setup){.start = *start}, &device, &err));
    return device;
}

static double length_of(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double angle_between(const ost_pose *a, const ost_pose *b)
{
    /*
     * The angle is computed from the chord between the quaternions, because the cosine of a
     * small angle is not precise enough.
     */
    double apart = 0, together = 0;
    for (int i = 0; i < 4; i++) {
        const double p = (double)(&a->qw)[i] / OST_Q30_ONE, q = (double)(&b->qw)[i] / OST_Q30_ONE;
        apart += (p - q) * (p - q);
        together += (p + q) * (p + q);
    }
    return 4 * asin(fmin(1, sqrt(fmin(apart, together)) / 2));
}

static void check_motion(const char *file)
{
    const int32_t c = 759250125;
    const ost_pose start = {.t = {10 * MM, 20 * MM, 30 * MM}, .qw = c, .qz = c};
    ost_haptic *device = open_motion(file, ",scale=10", &start);
    ost_haptic_state s = {.tool = 5}, last = {.pose = start};
    ost_haptic_answer answer;
    int fresh = 0, tracking_lost = 0, dropouts = 0, in_segment = 0;
    bool was_lost = false;
    ost_pose base = start;
    while ((answer = ost_haptic_read(device, &s)) != OST_HAPTIC_ENDED) {
        if (answer == OST_HAPTIC_NOT_TRACKED) {
            dropouts += tracking_lost == 0 || !was_lost;
            tracking_lost++;
            was_lost = true;
            continue;
        }
        assert_int_equal(answer, OST_HAPTIC_FRESH);
        assert_int_equal(s.tool, -1);
        if (was_lost || fresh == 0) {
            /* The clutch engages at the tool's pose, to within the rounding of a pose. */
            base = last.pose;
            in_segment = 0;
            assert_true(llabs(s.pose.t.x - base.t.x) <= 2 && llabs(s.pose.t.y - base.t.y) <= 2 &&
                        llabs(s.pose.t.z - base.t.z) <= 2);
            assert_true(angle_between(&s.pose, &base) < 1e-6);
        }
        /* The tool performs a tenth of the body's translation and all of its rotation. */
        const double moved[3] = {(double)(s.pose.t.x - base.t.x) * 1e-12, (double)(s.pose.t.y - base.t.y) * 1e-12,
                                 (double)(s.pose.t.z - base.t.z) * 1e-12};
        const double way = 0.1 * 0.2 * in_segment * 1e-3, turned = 2 * in_segment * 1e-3;
        assert_true(fabs(length_of(moved) - way) < 2e-6 * 0.1 + 1e-9);
        assert_true(fabs(angle_between(&s.pose, &base) - turned) < 1e-5);
        /*
         * To get the expected direction, the direction of the body's motion is transformed to the body's
         * frame at the first tracked row, and then rotated by the tool's start pose. The expected direction
         * is the same after the drop-outs.
         */
        double at[3], q[4];
        body_at(row_time(20), at, q);
        const double x = 2 * (q[1] * q[2] + q[0] * q[3]), y = 1 - 2 * (q[1] * q[1] + q[3] * q[3]),
                     z = 2 * (q[2] * q[3] - q[0] * q[1]);
        const double expected[3] = {-y, x, z}; /* The start pose rotates the x axis to the y axis. */
        for (int a = 0; a < 3; a++)
            assert_true(fabs(moved[a] - way * expected[a]) < 1e-6);
        was_lost = false;
        last = s;
        fresh++;
        in_segment++;
    }
    ost_haptic_close(device);
    /*
     * Rows 0 to 399 take 1.3965 s. The hand is not tracked for 70 ms at the start, for 353 ms
     * between rows 119 and 220, for 104 ms between rows 300 and 330, and for 35 ms after row
     * 389.
     */
    assert_int_equal(fresh + tracking_lost, 1 + 1396);
    assert_int_equal(dropouts, 4);
    assert_int_equal(tracking_lost, 70 + 353 + 104 + 35);
}

static void poses_follow_the_recording(void **state)
{
    (void)state;
    static char text[100000];
    const size_t size = write_motion(text, sizeof text);
    check_motion(scratch_write(folder, "hand.csv", text, size));
    /* A compressed file gives the same motion. */
    char packed[4200];
    snprintf(packed, sizeof packed, "%s/hand.csv.gz", folder);
    gzFile gz = gzopen(packed, "wb");
    assert_non_null(gz);
    assert_int_equal(gzwrite(gz, text, (unsigned)size), (int)size);
    assert_int_equal(gzclose(gz), Z_OK);
    check_motion(packed);
    /* A truncated file must be refused. */
    size_t total_bytes;
    char *bytes = scratch_read(packed, &total_bytes);
    const char *cut = scratch_write(folder, "cut.csv.gz", bytes, total_bytes / 2);
    free(bytes);
    char spec[4300];
    ost_error err = {0};
    ost_haptic *device;
    snprintf(spec, sizeof spec, "motion:%s", cut);
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "cut.csv.gz: the gzip data are damaged or cut off after"));
}

static void with_longer_gaps_allowed(void **state)
{
    (void)state;
    static char text[100000];
    const char *file = scratch_write(folder, "gaps.csv", text, write_motion(text, sizeof text));
    const ost_pose start = {.qw = OST_Q30_ONE};
    ost_haptic *device = open_motion(file, ",gap=200,jump=50", &start);
    ost_haptic_state s;
    ost_haptic_answer answer;
    int tracking_lost = 0;
    while ((answer = ost_haptic_read(device, &s)) != OST_HAPTIC_ENDED)
        tracking_lost += answer == OST_HAPTIC_NOT_TRACKED;
    /*
     * The device interpolates across missing rows, but not across rows that declare lost tracking.
     */
    assert_int_equal(tracking_lost, 70 + 353 + 35);
    ost_haptic_close(device);
}

/*
 * In a recording at 1 kHz, the hand moves by 20 mm between two rows. If no option allows jumps of this size, the hand
 * counts as not tracked between these rows. The positions are in millimetres.
 */
static void jump_counts_as_not_tracked(void **state)
{
    (void)state;
    static const struct {
        const char *options;
        ost_path_options gaps;
        int tracking_lost;
    } cases[] = {{"", {0}, 1},
                 {",jump=30", {0}, 0},
                 {"", {0, 30 * MM}, 0},
                 {"", {OST_PATH_NO_GAPS, OST_PATH_NO_GAPS}, 0},
                 {",jump=1", {0, 30 * MM}, 1}};
    static const char text[] = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.001,0.1,0,0,1,0,0,0\n0.0025,20.1,0,"
                               "0,1,0,0,0\n0.003,20.2,0,0,1,0,0,0\n";
    const char *file = scratch_write(folder, "jump.csv", text, sizeof text - 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char spec[4300];
        ost_error err = {0};
        ost_haptic *device;
        ost_haptic_state s;
        ost_haptic_answer answer;
        int tracking_lost = 0;
        snprintf(spec, sizeof spec, "motion:%s%s", file, cases[i].options);
        assert_ok(ost_haptic_open(spec, &(ost_haptic_setup){.start = ost_pose_identity(), .gaps = cases[i].gaps},
                                  &device, &err));
        while ((answer = ost_haptic_read(device, &s)) != OST_HAPTIC_ENDED)
            tracking_lost += answer == OST_HAPTIC_NOT_TRACKED;
        assert_int_equal(tracking_lost, cases[i].tracking_lost);
        ost_haptic_close(device);
    }
}

static void refuses_invalid_motions(void **state)
{
    (void)state;
    static const struct {
        const char *text, *options, *message;
        ost_status status;
    } cases[] = {
        {"", "", "bad.csv: file is empty", OST_ERR_INPUT},
        {"t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,nan,0,0,0\n", "", "bad.csv: no row has a pose", OST_ERR_INPUT},
        {"t_s,x_cm,y_cm,z_cm,qw,qx,qy,qz\n", "", "bad.csv:1: column 2 is named 'x_cm'", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0\n", "", "bad.csv:1: 7 columns", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n", "", "bad.csv:2: t_s is 0.000000000, not after", OST_ERR_INPUT},
        {"nan,0,0,0,1,0,0,0\n", "", "bad.csv:1: column 1 (t_s) is 'nan'", OST_ERR_INPUT},
        {"0,0,1e9,0,1,0,0,0\n", "", "bad.csv:1: position y is beyond 8000 mm", OST_ERR_RANGE},
        {"0,0,0,0,0.5,0,0,0\n", "", "bad.csv:1: quaternion", OST_ERR_RANGE},
        {"0,0,0,0,1,0,0,inf\n", "", "column 8 (qz) is 'inf'", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,99999999999999999999\n", "", "bad.csv:1: quaternion component qz", OST_ERR_RANGE},
        {"0,0,0,0,1,0,0,0x1\n", "", "column 8 (qz) is '0x1'", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n86400.1,0,0,0,1,0,0,0\n", "",
         "bad.csv: lasts from 0 to 86400.1 s; device motion plays a day at most", OST_ERR_RANGE},
        {"\x01\x02\x03\n", "", "bad.csv:1: binary data", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n", ",scale=0", "scale=0; expected a number from 0.1 to 1000", OST_ERR_USAGE},
        {"0,0,0,0,1,0,0,0\n", ",scale=nan", "scale=nan", OST_ERR_USAGE},
        {"0,0,0,0,1,0,0,0\n", ",jump=0", "jump=0; expected a number from 0.1 to 1000", OST_ERR_USAGE},
        {"0,0,0,0,1,0,0,0\n", ",speed=2", "unknown option 'speed'", OST_ERR_USAGE},
    };
    char spec[4300];
    ost_error err = {0};
    ost_haptic *device;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *file = scratch_write(folder, "bad.csv", cases[i].text, strlen(cases[i].text));
        snprintf(spec, sizeof spec, "motion:%s%s", file, cases[i].options);
        assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), cases[i].status);
        assert_null(device);
        if (!strstr(err.text, cases[i].message))
            fail_msg("'%s': the error '%s' does not contain '%s'", cases[i].text, err.text, cases[i].message);
    }
    static char long_line[10000];
    memset(long_line, '1', sizeof long_line - 1);
    snprintf(spec, sizeof spec, "motion:%s", scratch_write(folder, "long.csv", long_line, sizeof long_line - 1));
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "long.csv:1: the line is longer than 4096 bytes"));
    snprintf(spec, sizeof spec, "motion:%s", scratch_write(folder, "zero.csv", "0,0,0\0,1\n", 9));
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "zero.csv:1: "));
    assert_int_equal(ost_haptic_open("motion", NULL, &device, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "no file given"));
    assert_int_equal(ost_haptic_open("motion:nowhere.csv", NULL, &device, &err), OST_ERR_IO);
    snprintf(spec, sizeof spec, "motion:%s", folder);
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_IO);
    /* A file with a single pose is a motion of one tick. */
    const char *file = scratch_write(folder, "one.csv", "# a comment\r\n\r\n0 0 0 0 1 0 0 0\r\n", 32);
    device = open_motion(file, "", &(ost_pose){.qw = OST_Q30_ONE});
    ost_haptic_state s;
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_ENDED);
    ost_haptic_close(device);
}

/* --------------------------------------------------- motions in a world */

static ost_servo_report report;

static void dropouts_remove_nothing_and_are_recorded(void **state)
{
    ost_error err = {0};
    static char text[100000];
    const char *written = scratch_write(folder, "operate.csv", text, write_motion(text, sizeof text));
    char file[4200], session_name[4200];
    snprintf(file, sizeof file, "%s", written);
    snprintf(session_name, sizeof session_name, "%s/m.session", folder);

    const ost_geometry g = cubic_geometry(40, 40, 40, MM, (ost_pm3){0, 0, 0});
    int16_t *full = malloc(voxel_count(&g) * sizeof *full);
    assert_non_null(full);
    for (size_t i = 0; i < voxel_count(&g); i++)
        full[i] = 500;
    ost_bone *bones[2];
    ost_world *worlds[2];
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{4, 4, 12}, 500 * UM, {-MM, -MM, 0}}, OST_TOOL_CUTTING);
    for (int i = 0; i < 2; i++) {
        bones[i] = bone_of(*state, &g, 16, full);
        assert_ok(ost_world_create(bones[i], NULL, &worlds[i], &err));
        assert_ok(ost_world_add_tool(worlds[i], "peg", tool, NULL, &err));
    }
    free(full);

    ost_session_header *header;
    ost_recorder *recorder;
    ost_operation *operation;
    ost_operation_report done;
    assert_ok(ost_session_header_create(&header, &err));
    assert_ok(ost_recorder_open(session_name, header, NULL, &recorder, &err));
    ost_session_header_free(header);
    ost_haptic *device = open_motion(file, "", &(ost_pose){.t = {20 * MM, 20 * MM, 20 * MM}, .qw = OST_Q30_ONE});
    assert_ok(ost_operation_create(worlds[0], &(ost_operation_options){.recorder = recorder, .rpm = OST_RPM_ON},
                                   &operation, &err));
    assert_ok(ost_servo_run(device, &(ost_servo_options){.no_clock = true, .no_realtime = true}, ost_operation_tick,
                            ost_operation_done, operation, &report, &err));
    ost_operation_report_get(operation, &done);
    ost_operation_free(operation);
    ost_haptic_close(device);
    assert_ok(ost_recorder_close(recorder, &(ost_session_end){.ticks = done.steps}, &err));

    assert_int_equal(report.end, OST_SERVO_DEVICE_ENDED);
    assert_int_equal(report.ticks, 1397);
    assert_int_equal(report.tracking_lost, done.dropout_ticks);
    assert_int_equal(report.without_sample, 0);
    assert_int_equal(done.faults, 0);
    assert_int_equal(done.dropouts, 4);
    assert_int_equal(done.dropout_ticks, 70 + 353 + 104 + 35);
    assert_int_equal(done.longest_dropout, 353);
    assert_int_equal(done.steps, 1397 - done.dropout_ticks);
    ost_world_totals totals;
    ost_world_totals_get(worlds[0], &totals);
    assert_true(totals.removed_voxels > 20);

    /*
     * Replaying the session must give the same bone. In the session, a drop-out is an interval without
     * ticks, with a note at its end.
     */
    ost_session *session;
    assert_ok(ost_session_open(session_name, &session, &err));
    int notes = 0;
    int64_t last_t = 0, dark = 0;
    ost_pose last = {0};
    for (;;) {
        ost_record record;
        bool more;
        ost_step_result step;
        assert_ok(ost_session_next(session, &record, &more, &err));
        if (!more)
            break;
        if (record.kind == OST_RECORD_NOTE)
            assert_non_null(
                strstr(record.as.note.text, notes++ % 2 ? "sees the hand again after" : "does not see the hand"));
        if (record.kind != OST_RECORD_TICK)
            continue;
        const ost_tick *t = &record.as.tick.tick;
        if (t->t_ns - last_t > 1000000 && record.as.tick.number > 0) {
            dark += t->t_ns - last_t - 1000000;
            assert_true(llabs(t->pose.t.x - last.t.x) <= 2 && llabs(t->pose.t.y - last.t.y) <= 2 &&
                        llabs(t->pose.t.z - last.t.z) <= 2);
        }
        last_t = t->t_ns;
        last = t->pose;
        assert_ok(ost_world_step(worlds[1], t, &step, &err));
        assert_true(ost_step_digest(&step, ost_world_classes(worlds[1])->count) == record.as.tick.digest);
    }
    ost_session_close(session);
    assert_int_equal(notes, 7); /* There is no note for the last drop-out, because it does not end. */
    assert_int_equal(dark, (353 + 104) * 1000000);
    const ost_digest a = digest_of(bones[0]), b = digest_of(bones[1]);
    assert_true(ost_digest_equal(&a, &b));
    for (int i = 0; i < 2; i++) {
        ost_world_free(worlds[i]);
        ost_bone_free(bones[i]);
    }
    ost_tool_free(tool);
}

int main(void)
{
    const struct CMUnitTest files[] = {
        cmocka_unit_test(poses_follow_the_recording),
        cmocka_unit_test(with_longer_gaps_allowed),
        cmocka_unit_test(jump_counts_as_not_tracked),
        cmocka_unit_test(refuses_invalid_motions),
    };
    const struct CMUnitTest worlds[] = {
        cmocka_unit_test(dropouts_remove_nothing_and_are_recorded),
    };
    int failed = cmocka_run_group_tests(files, make_folder, remove_folder);
    folder = scratch_folder();
    failed += run_on_backends(worlds, open_test_backend, close_test_backend);
    scratch_remove(folder);
    return failed;
}
