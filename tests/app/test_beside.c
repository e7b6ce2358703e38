/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames beside the loops of comparison: what the ticks' frames took is done
 * again, backward and forward, and where there are none the pauses of loops
 * that draw nothing are counted.
 * Covers: REQ-BESIDE
 */
#include <osteon/haptics.h>
#include <time.h>

#include "app/sim_beside.h"
#include "harness.h"

#define MM OST_PM_PER_MM
enum { BLOCKS = 4, FRAMES = 5 };

static sim_beside b;
static ost_viewer v;

static ost_pose pose_of(int frame)
{
    ost_pose pose = ost_pose_identity();
    pose.t.x = frame * MM;
    return pose;
}

/* Four blocks in a row, each with something in it. */
static void begin(void)
{
    const ost_geometry g = {{32 * BLOCKS, 32, 32}, {MM, MM, MM}, {0, 0, 0}};
    ost_error err = {0};
    ost_volume volume;
    b = (sim_beside){.stage = SIM_BESIDE_NOT_BEGUN, .wanted = true};
    assert_ok(ost_volume_init(&volume, &g, &err));
    for (size_t i = 0; i < BLOCKS; i++)
        volume.voxels[32 * i + 16 + 32 * BLOCKS * (16 + 32 * 16)] = 700;
    assert_ok(ost_viewer_init(&v, &g, OST_STYLE_SMOOTH, "scalar", 1, &err));
    assert_ok(ost_surface_set_volume(&v.bone, &volume, 120, &err));
    assert_ok(ost_viewer_update(&v, &err));
    assert_int_equal(v.bone.used, BLOCKS);
    ost_volume_free(&volume);
}

static void end(void)
{
    ost_viewer_free(&v);
}

/* A frame in which these blocks were listed, as bits. */
static void frame(int number, unsigned blocks)
{
    ost_error err = {0};
    v.state.pose = pose_of(number);
    for (int i = 0; i < BLOCKS; i++)
        v.bone.slot[i]->dirty = blocks >> i & 1;
    assert_ok(ost_surface_update(&v.bone, &err));
    assert_ok(sim_beside_update(&b, &v, &err));
}

/* A frame in which nothing happened; which blocks were listed for it. */
static unsigned again(void)
{
    ost_error err = {0};
    uint64_t before[BLOCKS];
    unsigned listed = 0;
    v.state.pose = pose_of(99);
    for (int i = 0; i < BLOCKS; i++)
        before[i] = v.bone.slot[i]->version;
    assert_ok(ost_viewer_update(&v, &err));
    assert_ok(sim_beside_update(&b, &v, &err));
    for (int i = 0; i < BLOCKS; i++)
        listed |= (unsigned)(v.bone.slot[i]->version != before[i]) << i;
    return listed;
}

static void the_same_frames_again(void **state)
{
    static const unsigned blocks[FRAMES] = {15, 1, 0, 6, 8};
    (void)state;
    begin();
    /* Before the ticks nothing is kept. */
    frame(7, 3);
    assert_false(sim_beside_ticks(&b));
    b.stage = OST_SERVO_TICKING;
    assert_true(sim_beside_ticks(&b));
    assert_int_equal(again(), 0); /* what is listed by then is no frame's */
    /* Nor is what was drawn before there was a tool to draw. */
    v.has_state = false;
    frame(90, 5);
    v.has_state = true;
    v.state.ticks = 0;
    frame(91, 5);
    v.state.ticks = 1;
    for (int i = 0; i < FRAMES; i++)
        frame(i, blocks[i]);
    assert_false(sim_beside_again(&b));
    b.stage = OST_SERVO_BUSY;
    assert_true(sim_beside_again(&b));
    static const int order[] = {4, 3, 2, 1, 0, 1, 2, 3, 4, 3};
    for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
        assert_int_equal(again(), blocks[order[i]]);
        const ost_pose pose = pose_of(order[i]);
        assert_int_equal(v.state.pose.t.x, pose.t.x);
        b.stage = OST_SERVO_QUIET; /* goes on in it */
    }
    b.stage = OST_SERVO_RESTED;
    assert_false(sim_beside_again(&b));
    end();
}

/* More frames than are kept: the last of them. More blocks in one than are kept: some of them, and nothing beyond. */
static void as_many_as_there_is_room_for(void **state)
{
    (void)state;
    begin();
    v.has_state = true;
    v.state.ticks = 1;
    b.stage = OST_SERVO_TICKING;
    for (int i = 0; i < SIM_BESIDE_FRAMES + 10; i++)
        frame(i, 1u << i % BLOCKS);
    b.stage = OST_SERVO_QUIET;
    for (int i = 0; i < SIM_BESIDE_FRAMES; i++) {
        assert_int_equal(again(), 1u << (SIM_BESIDE_FRAMES + 9 - i) % BLOCKS);
        assert_int_equal(v.state.pose.t.x, (SIM_BESIDE_FRAMES + 9 - i) * MM);
    }
    again();
    assert_int_equal(v.state.pose.t.x, 11 * MM); /* the oldest was 10: forward again */
    /* None wanted: nothing is kept, nothing done again. */
    b = (sim_beside){.stage = OST_SERVO_TICKING};
    frame(0, 15);
    frame(1, 15);
    b.stage = OST_SERVO_BUSY;
    assert_false(sim_beside_again(&b));
    assert_int_equal(again(), 0);
    end();
}

static void a_loop_without_frames(void **state)
{
    static frame_times drawn;
    (void)state;
    b = (sim_beside){.stage = OST_SERVO_QUIET};
    frame_times_add(&drawn, 30000000);
    assert_false(sim_beside_rests(&b, &drawn));
    b.stage = OST_SERVO_RESTED;
    const struct timespec pause = {.tv_nsec = 10000000};
    /* A quarter of a second of turns that only wake, then turns that spend 30 ms each. */
    for (int i = 0; i < 2000 && b.spent.count < 3; i++) {
        assert_true(sim_beside_rests(&b, &drawn));
        nanosleep(&pause, NULL);
    }
    assert_int_equal(b.spent.count, 3);
    assert_true(b.woken.count > 0 && b.woken.count <= 25);
    assert_true(frame_times_ms(&b.woken, 0.5) >= 10);
    assert_true(frame_times_ms(&b.spent, 0.5) >= 39.9); /* pause and frame */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_frames_again),
        cmocka_unit_test(as_many_as_there_is_room_for),
        cmocka_unit_test(a_loop_without_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
