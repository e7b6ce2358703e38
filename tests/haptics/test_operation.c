/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests operations. A device must change a world exactly as the same path does without a device. Input that cannot come
 * from a hand must change nothing. All ticks must be recorded.
 *
 * Covers: REQ-OPERATION, REQ-SAFETY, REQ-RECORDER
 */
#include "operation_world.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#include "io/io_scratch.h"
#include "io/session/recorder.h"

/* Returns a path into the bone along x, 0.1 mm per tick. */
static ost_path into_bone(size_t count)
{
    ost_error err = {0};
    ost_path path;
    assert_ok(ost_path_init(&path, count, &err));
    for (size_t i = 0; i < count; i++)
        path.ticks[i] = (ost_tick){.t_ns = (int64_t)i * 1000000,
                                   .rpm = OST_RPM_ON,
                                   .pose = {.t = {-5 * MM + (int64_t)i * MM / 10, 10 * MM, 5 * MM}, .qw = OST_Q30_ONE}};
    return path;
}

static ost_servo_report report;

static ost_operation_report operate(fixture *r, const char *device_spec, const ost_path *path, ost_recorder *recorder)
{
    ost_error err = {0};
    ost_haptic *device;
    ost_operation *operation;
    ost_operation_report done;
    assert_ok(ost_haptic_open(device_spec, &(ost_haptic_setup){.path = path}, &device, &err));
    assert_ok(ost_operation_create(r->world, &(ost_operation_options){.recorder = recorder}, &operation, &err));
    const ost_servo_options options = {.no_clock = true, .no_realtime = true};
    assert_ok(ost_servo_run(device, &options, ost_operation_tick, ost_operation_done, operation, &report, &err));
    ost_operation_report_get(operation, &done);
    ost_operation_free(operation);
    ost_haptic_close(device);
    return done;
}

static void script_equals_its_path(void **state)
{
    ost_error err = {0};
    fixture by_hand = make_fixture(*state), by_device = make_fixture(*state);
    ost_path path = into_bone(200);
    for (size_t i = 0; i < path.count; i++)
        assert_ok(ost_world_step(by_hand.world, &path.ticks[i], NULL, &err));
    const ost_operation_report done = operate(&by_device, "script", &path, NULL);
    assert_int_equal(done.steps, 200);
    assert_int_equal(done.faults, 0);
    assert_int_equal(report.end, OST_SERVO_DEVICE_ENDED);
    const ost_digest a = digest_of(by_hand.bone), b = digest_of(by_device.bone);
    assert_true(ost_digest_equal(&a, &b));
    ost_world_totals totals;
    ost_world_totals_get(by_device.world, &totals);
    assert_true(totals.removed_voxels > 100);
    ost_path_free(&path);
    free_fixture(&by_hand);
    free_fixture(&by_device);
}

/* The faulty rows of a path must not affect the bone. The expected bone comes from a path without these rows. */
static void impossible_poses_are_ignored(void **state)
{
    ost_error err = {0};
    static const struct {
        ost_fault fault;
        size_t from, to;
        ost_pose pose;
        int32_t tool;
    } cases[] = {
        /* The tool jumps away and comes back. */
        {OST_FAULT_JUMP, 100, 105, {{-100 * MM, 10 * MM, 5 * MM}, OST_Q30_ONE, 0, 0, 0}, 0},
        /* The tool rotates by half a turn within one tick, at the same position. */
        {OST_FAULT_TURN, 100, 101, {{-5 * MM + 100 * MM / 10, 10 * MM, 5 * MM}, 0, OST_Q30_ONE, 0, 0}, 0},
        /* The quaternion is zero and therefore not a rotation. */
        {OST_FAULT_TURN, 50, 60, {{0, 0, 0}, 0, 0, 0, 0}, 0},
        {OST_FAULT_TOOL, 30, 33, {{-5 * MM + 30 * MM / 10, 10 * MM, 5 * MM}, OST_Q30_ONE, 0, 0, 0}, 9},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        fixture expected = make_fixture(*state), got = make_fixture(*state);
        ost_path path = into_bone(200);
        for (size_t i = 0; i < path.count; i++)
            if (i < cases[c].from || i >= cases[c].to)
                assert_ok(ost_world_step(expected.world, &path.ticks[i], NULL, &err));
        for (size_t i = cases[c].from; i < cases[c].to; i++) {
            path.ticks[i].pose = cases[c].pose;
            path.ticks[i].tool = cases[c].tool;
        }
        const ost_operation_report done = operate(&got, "script", &path, NULL);
        assert_int_equal(done.faults, 1);
        assert_int_equal(done.fault_ticks, cases[c].to - cases[c].from);
        assert_int_equal(done.last_fault, cases[c].fault);
        assert_int_equal(done.steps, 200 - (cases[c].to - cases[c].from));
        assert_int_equal(done.status, OST_OK);
        const ost_digest a = digest_of(expected.bone), b = digest_of(got.bone);
        assert_true(ost_digest_equal(&a, &b));
        ost_path_free(&path);
        free_fixture(&expected);
        free_fixture(&got);
    }
}

/*
 * The tool jumps and does not return. It must stay at the position before the jump, so only a few
 * voxels are removed.
 */
static void jump_removes_nothing_on_its_way(void **state)
{
    fixture r = make_fixture(*state);
    ost_path path = into_bone(60);
    /*
     * The tool jumps through the entire bone in one tick. Although a sweep could span this distance, there must be no
     * sweep, because no hand moves this far in one tick.
     */
    for (size_t i = 50; i < 60; i++)
        path.ticks[i].pose.t.x = 45 * MM;
    const ost_operation_report done = operate(&r, "script", &path, NULL);
    assert_int_equal(done.fault_ticks, 10);
    assert_int_equal(done.steps, 50);
    ost_world_totals totals;
    ost_world_totals_get(r.world, &totals);
    assert_int_equal(totals.ticks, 50);
    assert_true(totals.removed_voxels < 50);
    assert_string_equal(ost_fault_text(OST_FAULT_JUMP), "the pose jumped");
    ost_path_free(&path);
    free_fixture(&r);
}

/*
 * Pressing a tool of rigid points into bone must give a force. A jump of the pose is a fault. After the fault, the
 * force must become zero and then increase gradually.
 */
typedef struct force_record {
    ost_operation *operation;
    double n[400];
    size_t count;
} force_record;

static bool record_force(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    force_record *f = user;
    const bool more = ost_operation_tick(f->operation, sample, wrench);
    f->n[f->count++] = wrench->force_n[0];
    return more;
}

static void fault_sets_the_force_to_zero(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    fixture r = make_fixture(*state);
    ost_force_params params = ost_force_defaults();
    ost_safety_params safety = ost_safety_defaults();
    ost_force *force;
    ost_haptic *device;
    static force_record f;
    params.speed = 0;
    safety.ramp_s = 0.05;
    f = (force_record){0};
    ost_path path = into_bone(400);
    for (size_t i = 0; i < path.count; i++) /* The peg moves by 2 mm along x, into the bone's side. */
        path.ticks[i].pose.t.x = -2 * MM + (ost_pm)(i < 200 ? i : 200) * MM / 100;
    path.ticks[300].pose.t.y += 50 * MM;
    /*
     * Tool 1 exists in the force model, but not in the world. Its force is computed and must not be written
     * to the device.
     */
    for (size_t i = 360; i < 370; i++) {
        path.ticks[i].tool = 1;
        path.ticks[i].pose.t.x += (ost_pm)(i - 359) * MM / 10;
    }
    assert_ok(ost_force_create(r.bone, &params, &force, &err));
    assert_ok(ost_force_add_tool(force, r.tool, &err));
    assert_ok(ost_force_add_tool(force, r.tool, &err));
    assert_ok(ost_haptic_open("script", &(ost_haptic_setup){.path = &path}, &device, &err));
    assert_ok(
        ost_operation_create(r.world, &(ost_operation_options){.force = force, .safety = &safety}, &f.operation, &err));
    assert_ok(ost_servo_run(device, &(ost_servo_options){.no_clock = true, .no_realtime = true}, record_force, NULL, &f,
                            &report, &err));
    ost_operation_report done;
    ost_operation_report_get(f.operation, &done);
    assert_int_equal(done.faults, 2);
    assert_int_equal(f.count, 400);
    assert_true(f.n[0] == 0 && f.n[299] < -0.1);
    assert_true(f.n[300] == 0);
    assert_true(f.n[301] > 0.1 * f.n[299] && f.n[359] < 0.9 * f.n[299]);
    for (size_t i = 360; i < 370; i++)
        assert_true(f.n[i] == 0);
    assert_true(done.peak_n >= -f.n[299]);
    ost_operation_free(f.operation);
    ost_haptic_close(device);
    ost_force_free(force);
    ost_path_free(&path);
    free_fixture(&r);
}

/*
 * Every tick is rehearsed at least once. The forces and the bone must equal those of an operation without
 * rehearsals.
 */
static void rehearsals_change_no_result(void **state)
{
    skip_without_samples(*state);
    enum { TICKS = 200 };
    static ost_wrench wrenches[2][TICKS];
    ost_error err = {0};
    ost_digest digests[2];
    ost_operation_report done[2];
    ost_force_params params = ost_force_defaults();
    params.vibration = params.runout = 0.2;
    params.turn_stiffness = 0.5;
    params.turn_damping = 0.001;
    ost_path path = into_bone(TICKS);
    for (size_t i = 0; i < TICKS; i++) { /* The tool moves at 20 mm/s; one pose is invalid. */
        path.ticks[i].pose.t.x = -2 * MM + (ost_pm)i * MM / 50;
        path.ticks[i].pose.t.y += (ost_pm)(i * i % 7) * MM / 10;
    }
    path.ticks[120].pose.qw = 0;
    for (int r = 0; r < 2; r++) {
        fixture it = make_fixture(*state);
        ost_force *force;
        ost_operation *operation;
        assert_ok(ost_force_create(it.bone, &params, &force, &err));
        assert_ok(ost_force_add_tool(force, it.tool, &err));
        assert_ok(ost_operation_create(it.world, &(ost_operation_options){.force = force, .rpm = OST_RPM_ON},
                                       &operation, &err));
        for (size_t i = 0; i < TICKS; i++) {
            const ost_servo_sample sample = {
                .number = i, .t_ns = path.ticks[i].t_ns, .state = {.pose = path.ticks[i].pose, .tool = -1}};
            wrenches[r][i] = (ost_wrench){{0}, {0}};
            for (size_t n = 0; r == 1 && n < i % 3 + 1; n++)
                ost_operation_rehearse(operation);
            assert_true(ost_operation_tick(operation, &sample, &wrenches[r][i]));
            ost_operation_done(operation, i, 0);
        }
        ost_operation_report_get(operation, &done[r]);
        digests[r] = digest_of(it.bone);
        ost_operation_free(operation);
        ost_force_free(force);
        free_fixture(&it);
    }
    assert_memory_equal(wrenches[0], wrenches[1], sizeof wrenches[0]);
    assert_true(ost_digest_equal(&digests[0], &digests[1]));
    assert_int_equal(done[0].steps, TICKS - 1);
    assert_int_equal(done[1].steps, TICKS - 1);
    assert_true(done[0].energy_j > 0 && done[0].energy_j == done[1].energy_j);
    assert_int_equal(done[0].touching_ticks, done[1].touching_ticks);
    ost_path_free(&path);
}

static void replayed_session_gives_the_same_bone(void **state)
{
    ost_error err = {0};
    char *folder = scratch_folder(), path_name[4200];
    snprintf(path_name, sizeof path_name, "%s/o.session", folder);
    fixture r = make_fixture(*state);
    ost_path path = into_bone(300);
    path.ticks[80].pose.t.y = -100 * MM; /* Only this tick has an impossible pose. */
    ost_session_header *header;
    ost_recorder *recorder;
    assert_ok(ost_session_header_create(&header, &err));
    assert_ok(ost_recorder_open(path_name, header, NULL, &recorder, &err));
    ost_session_header_free(header);
    const ost_operation_report done = operate(&r, "script", &path, recorder);
    assert_int_equal(done.steps, 299);
    assert_ok(ost_recorder_close(recorder, &(ost_session_end){.ticks = done.steps}, &err));

    fixture again = make_fixture(*state);
    ost_session *session;
    assert_ok(ost_session_open(path_name, &session, &err));
    assert_int_equal(ost_session_summary_of(session)->complete_ticks, 299);
    int notes = 0;
    uint64_t ticks = 0;
    for (;;) {
        ost_record record;
        bool more;
        ost_step_result step;
        assert_ok(ost_session_next(session, &record, &more, &err));
        if (!more)
            break;
        notes += record.kind == OST_RECORD_NOTE;
        if (record.kind != OST_RECORD_TICK)
            continue;
        const ost_session_tick *t = &record.as.tick;
        assert_int_equal(t->number, ticks++);
        assert_ok(ost_world_step(again.world, &t->tick, &step, &err));
        assert_true(ost_step_digest(&step, ost_world_classes(again.world)->count) == t->digest);
        assert_int_equal(t->removed, step.report->total_voxels);
        /* Time also advances in the skipped tick. */
        assert_int_equal(t->tick.t_ns, (int64_t)(t->number + (t->number >= 80)) * 1000000);
    }
    assert_int_equal(ticks, 299);
    assert_int_equal(notes, 2);
    const ost_digest a = digest_of(r.bone), b = digest_of(again.bone);
    assert_true(ost_digest_equal(&a, &b));
    ost_session_close(session);
    ost_path_free(&path);
    free_fixture(&r);
    free_fixture(&again);
    scratch_remove(folder);
}

/*
 * A disk in memory. If the test locks `held`, the writer is blocked in the middle of a write. If the test
 * sets `full`, the disk is full.
 */
typedef struct disk {
    unsigned char bytes[1 << 17];
    size_t size;
    pthread_mutex_t held;
    _Atomic bool full;
} disk;

static int disk_append(void *user, const void *p, size_t size)
{
    disk *d = user;
    pthread_mutex_lock(&d->held);
    const int error = atomic_load(&d->full) || size > sizeof d->bytes - d->size ? ENOSPC : 0;
    if (!error) {
        memcpy(d->bytes + d->size, p, size);
        d->size += size;
    }
    pthread_mutex_unlock(&d->held);
    return error;
}

static int disk_cut(void *user, uint64_t size)
{
    ((disk *)user)->size = (size_t)size;
    return 0;
}

static int disk_sync(void *user)
{
    (void)user;
    return 0;
}

/*
 * Tests a blocked disk, a blocked disk with a small buffer, and a full disk. Every tick must be executed
 * with the same result, and the recorder must report the records that were not written. If a tick waited
 * for the disk, it would wait until the alarm ends the test, because the disk is released only after the
 * operation.
 */
static void ticks_do_not_wait_for_the_recorder(void **state)
{
    static const struct {
        uint32_t capacity;
        bool full;
        bool all; /* true if all records must be written in the end */
    } cases[] = {{1024, false, true}, {64, false, false}, {1024, true, false}};
    enum { TICKS = 200 };
    ost_error err = {0};
    fixture alone = make_fixture(*state);
    ost_path path = into_bone(TICKS);
    operate(&alone, "script", &path, NULL);
    const ost_digest expected = digest_of(alone.bone);
    alarm(120);
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        static disk d;
        ost_session_header *header;
        ost_recorder *recorder;
        ost_recorder_state now;
        d = (disk){.size = 0};
        pthread_mutex_init(&d.held, NULL);
        const session_sink sink = {.user = &d, .append = disk_append, .cut = disk_cut, .sync = disk_sync};
        fixture r = make_fixture(*state);
        assert_ok(ost_session_header_create(&header, &err));
        assert_ok(ost_session_header_set(header, "format", "osteon session 2", &err));
        assert_ok(ost_recorder_open_sink("disk", &sink, header, &(ost_recorder_options){.capacity = cases[c].capacity},
                                         &recorder, &err));
        atomic_store(&d.full, cases[c].full);
        pthread_mutex_lock(&d.held);
        const ost_operation_report done = operate(&r, "script", &path, recorder);
        assert_int_equal(done.steps, TICKS);
        assert_int_equal(done.status, OST_OK);
        const ost_digest got = digest_of(r.bone);
        assert_true(ost_digest_equal(&expected, &got));
        ost_recorder_state_get(recorder, &now);
        assert_int_equal(now.written, 0);
        assert_int_equal(now.put + now.lost, TICKS);
        assert_int_equal(now.lost > 0, cases[c].capacity < TICKS);
        pthread_mutex_unlock(&d.held);
        const ost_status closed = ost_recorder_close(recorder, &(ost_session_end){.ticks = TICKS}, &err);
        assert_int_equal(closed, cases[c].all ? OST_OK : OST_ERR_IO);
        if (cases[c].full)
            assert_non_null(strstr(err.text, "the disk is full; 0 records are in the file, 200 are not"));
        else if (!cases[c].all)
            assert_non_null(strstr(err.text, "were lost: the disk was too slow"));
        /* If the disk is not full, the file must contain two headers and all records that the recorder accepted. */
        assert_int_equal(d.size > (now.put + 1) * SESSION_RECORD, !cases[c].full);
        ost_session_header_free(header);
        pthread_mutex_destroy(&d.held);
        free_fixture(&r);
    }
    alarm(0);
    ost_path_free(&path);
    free_fixture(&alone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(script_equals_its_path),
        cmocka_unit_test(impossible_poses_are_ignored),
        cmocka_unit_test(jump_removes_nothing_on_its_way),
        cmocka_unit_test(fault_sets_the_force_to_zero),
        cmocka_unit_test(rehearsals_change_no_result),
        cmocka_unit_test(replayed_session_gives_the_same_bone),
        cmocka_unit_test(ticks_do_not_wait_for_the_recorder),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
