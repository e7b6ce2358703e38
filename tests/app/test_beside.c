/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The frames of the baseline runs: the drawing of the operation's frames is repeated, backward
 * and forward; without recorded frames, the pauses of loops that draw nothing are counted.
 * Covers: REQ-BESIDE
 */
#include <osteon/haptics.h>
#include <string.h>
#include <time.h>

#include "app/sim/baseline.h"
#include "harness.h"

#define MM OST_PM_PER_MM
enum { BLOCKS = 4, FRAMES = 5 };

static sim_beside b;
static ost_viewer v;
static int gone[BLOCKS];

static ost_pose pose_of(int frame)
{
    ost_pose pose = ost_pose_identity();
    pose.t.x = frame * MM;
    return pose;
}

/* Starts with four blocks in a row, full of bone. */
static void begin(void)
{
    const ost_geometry g = {{32 * BLOCKS, 32, 32}, {MM, MM, MM}, {0, 0, 0}};
    ost_error err = {0};
    ost_volume volume;
    b = (sim_beside){.stage = SIM_BESIDE_NOT_BEGUN, .wanted = true};
    memset(gone, 0, sizeof gone);
    assert_ok(ost_volume_init(&volume, &g, &err));
    for (size_t i = 0; i < 32 * 32 * 32 * BLOCKS; i++)
        volume.voxels[i] = 700;
    assert_ok(ost_viewer_init(&v, &g, OST_STYLE_SMOOTH, "scalar", 1, &err));
    assert_ok(ost_surface_set_volume(&v.bone, &volume, 120, &err));
    assert_ok(ost_viewer_update(&v, &err));
    assert_int_equal(v.bone.used, BLOCKS);
    v.has_state = true;
    v.state.ticks = 1;
    ost_volume_free(&volume);
}

static void end(void)
{
    sim_beside_free(&b);
    ost_viewer_free(&v);
}

/* Removes `count` more voxels of the blocks in the bit set, row by row. */
static void take(unsigned blocks, int count)
{
    ost_error err = {0};
    for (int i = 0; i < BLOCKS; i++) {
        uint32_t words[OST_BLOCK_ROWS];
        if (!(blocks >> i & 1))
            continue;
        memcpy(words, v.bone.slot[i]->occupied, sizeof words);
        for (int n = 0; n < count; n++, gone[i]++)
            words[gone[i] % OST_BLOCK_ROWS] &= ~(UINT32_C(1) << gone[i] / OST_BLOCK_ROWS);
        assert_ok(ost_surface_set(&v.bone, v.bone.slot[i]->at, words, &err));
    }
}

/* Counts the voxels of each block that are present. */
static void count_voxels(int out[BLOCKS])
{
    for (int i = 0; i < BLOCKS; i++) {
        out[i] = 0;
        for (int row = 0; row < OST_BLOCK_ROWS; row++)
            out[i] += __builtin_popcount(v.bone.slot[i]->occupied[row]);
    }
}

static void frame(int number)
{
    ost_error err = {0};
    v.state.pose = pose_of(number);
    assert_ok(sim_beside_update(&b, &v, &err));
}

static void is_as_at(int number, const int there[BLOCKS])
{
    int now[BLOCKS];
    count_voxels(now);
    for (int i = 0; i < BLOCKS; i++)
        assert_int_equal(now[i], there[i]);
    assert_int_equal(v.state.pose.t.x, number * MM);
}

static void the_same_frames_again(void **state)
{
    static const unsigned blocks[FRAMES] = {15, 1, 0, 6, 8};
    int there[FRAMES][BLOCKS], last[BLOCKS];
    (void)state;
    begin();
    /* Before the first tick nothing is recorded. */
    take(3, 1);
    frame(7);
    assert_false(sim_beside_ticks(&b));
    b.stage = OST_SERVO_TICKING;
    assert_true(sim_beside_ticks(&b));
    /* Frames drawn before the tool had a state are not recorded either. */
    v.has_state = false;
    frame(90);
    v.has_state = true;
    v.state.ticks = 0;
    frame(91);
    v.state.ticks = 1;
    for (int i = 0; i < FRAMES; i++) {
        take(blocks[i], 3 + i);
        frame(i);
        count_voxels(there[i]);
    }
    assert_false(sim_beside_again(&b));
    /* The changes of the last tick are drawn by the first frame after it. */
    b.stage = OST_SERVO_BUSY;
    assert_true(sim_beside_again(&b));
    take(2, 5);
    count_voxels(last);
    static const int order[] = {4, 3, 2, 1, 0, 1, 2, 3, 4, 5, 4, 3};
    for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
        frame(5);
        is_as_at(order[i], order[i] == 5 ? last : there[order[i]]);
        b.stage = OST_SERVO_QUIET; /* continues in the quiet loop */
    }
    /* All later frames show the bone as it is. */
    b.stage = OST_SERVO_RESTED;
    assert_false(sim_beside_again(&b));
    b.stage = SIM_BESIDE_NOT_BEGUN;
    frame(5);
    is_as_at(5, last);
    end();
}

/*
 * If there are more frames than fit, the last ones are recorded. If one frame has more changes
 * than fit, they are recorded with the next.
 */
static void as_many_as_there_is_room_for(void **state)
{
    static int there[SIM_BESIDE_FRAMES + 10][BLOCKS];
    int most = 0;
    (void)state;
    begin();
    b.stage = OST_SERVO_TICKING;
    for (int i = 0; i < SIM_BESIDE_FRAMES + 10; i++) {
        take(1u << i % BLOCKS, i % 50 == 49 ? SIM_BESIDE_ROWS + 100 : 2);
        frame(i);
        count_voxels(there[i]);
    }
    b.stage = OST_SERVO_QUIET;
    const int newest = SIM_BESIDE_FRAMES + 9;
    for (int i = 0; i < 2 * SIM_BESIDE_FRAMES; i++) {
        frame(newest);
        const int at = (int)(v.state.pose.t.x / MM);
        int now[BLOCKS];
        count_voxels(now);
        most = newest - at > most ? newest - at : most;
        for (int k = 0; k < BLOCKS; k++)
            assert_in_range(now[k], there[at][k], there[at][k] + 2 * (SIM_BESIDE_ROWS + 100));
    }
    assert_int_equal(most, SIM_BESIDE_FRAMES - 2); /* the frame after the last tick is one of them */
    b.stage = SIM_BESIDE_NOT_BEGUN;
    frame(newest);
    is_as_at(newest, there[newest]);
    end();
    /* Without baseline runs nothing is recorded and nothing is repeated. */
    begin();
    b.wanted = false;
    b.stage = OST_SERVO_TICKING;
    frame(0);
    frame(1);
    b.stage = OST_SERVO_BUSY;
    assert_false(sim_beside_again(&b));
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
    /* A quarter of a second of iterations that only wake, then iterations that take 30 ms each. */
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
