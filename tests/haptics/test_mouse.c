/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the `mouse` device. The device approaches a distant target in steps that the operation's pose guard
 * allows, until it reaches the target. A tool that is selected or lifted moves to its new pose at once. The
 * pedal is a button. If two threads use the device, no partial state is read.
 * Covers: REQ-MOUSE
 */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include <osteon/haptics.h>

#include "harness.h"

#define MM OST_PM_PER_MM

static ost_haptic_state at(double x, double y, double z, int32_t tool)
{
    ost_haptic_state s = {.pose = ost_pose_identity(), .tool = tool};
    s.pose.t = (ost_pm3){(ost_pm)(x * (double)MM), (ost_pm)(y * (double)MM), (ost_pm)(z * (double)MM)};
    return s;
}

static ost_haptic *open_mouse(const char *spec, ost_mouse_input **input)
{
    ost_error err = {0};
    ost_haptic *device;
    const ost_haptic_state start = at(1, 2, 3, 0);
    assert_ok(ost_mouse_input_create(&start, input, &err));
    assert_ok(ost_haptic_open(spec, &(ost_haptic_setup){.mouse = *input}, &device, &err));
    return device;
}

static double distance_mm(const ost_pose *a, const ost_pose *b)
{
    const double x = (double)(a->t.x - b->t.x), y = (double)(a->t.y - b->t.y), z = (double)(a->t.z - b->t.z);
    return sqrt(x * x + y * y + z * z) / (double)MM;
}

static double angle(const ost_pose *a, const ost_pose *b)
{
    const double one = (double)OST_Q30_ONE;
    const double c = ((double)a->qw * b->qw + (double)a->qx * b->qx + (double)a->qy * b->qy + (double)a->qz * b->qz) /
                     (one * one);
    return 2 * acos(fmin(1, fabs(c)));
}

static void device_approaches_the_target(void **state)
{
    ost_mouse_input *input;
    ost_haptic *device = open_mouse("mouse", &input);
    ost_haptic_state now, last;
    (void)state;
    assert_int_equal(ost_haptic_read(device, &last), OST_HAPTIC_FRESH);
    assert_int_equal(last.pose.t.y, 2 * MM);
    assert_int_equal(last.tool, 0);
    ost_haptic_state far = at(81, -40, 23, 0);
    far.pose.qw = far.pose.qy = 759250125; /* a quarter turn */
    ost_mouse_input_put(input, &far);
    for (int tick = 0; tick < 1500; tick++, last = now) {
        assert_int_equal(ost_haptic_read(device, &now), OST_HAPTIC_FRESH);
        assert_int_equal(ost_pose_check(&now.pose, NULL), OST_OK);
        assert_true(distance_mm(&now.pose, &last.pose) < 0.2501);
        assert_true(angle(&now.pose, &last.pose) < 0.03);
    }
    assert_true(distance_mm(&now.pose, &far.pose) < 0.001);
    assert_true(angle(&now.pose, &far.pose) < 0.001);
    ost_haptic_close(device);
    ost_mouse_input_free(input);
}

static void selected_tool_moves_at_once(void **state)
{
    ost_mouse_input *input;
    ost_haptic *device = open_mouse("mouse", &input);
    ost_haptic_state now, far = at(50, 50, 50, 2);
    (void)state;
    ost_haptic_read(device, &now);
    ost_mouse_input_put(input, &far);
    ost_haptic_read(device, &now);
    assert_int_equal(now.tool, 2);
    assert_true(distance_mm(&now.pose, &far.pose) < 0.001);
    ost_haptic_close(device);
    ost_mouse_input_free(input);
}

/* The pedal is a button: it switches the motor of the operation and does not change the pose. */
static void pedal_is_a_button(void **state)
{
    ost_mouse_input *input;
    ost_haptic *device = open_mouse("mouse", &input);
    ost_haptic_state first, now, put = at(1, 2, 3, 0);
    (void)state;
    ost_haptic_read(device, &first);
    put.buttons = OST_MOUSE_PEDAL;
    ost_mouse_input_put(input, &put);
    for (int tick = 0; tick < 250; tick++) {
        ost_haptic_read(device, &now);
        assert_int_equal(now.buttons, OST_MOUSE_PEDAL);
        assert_true(angle(&first.pose, &now.pose) < 1e-6);
    }
    ost_haptic_close(device);
    ost_mouse_input_free(input);
}

/*
 * A lifted tool moves to its new pose at once. The device must report "lifted" in exactly one
 * tick, even if the window sets the state several times before this tick.
 */
static void lifted_tool_moves_at_once(void **state)
{
    ost_mouse_input *input;
    ost_haptic *device = open_mouse("mouse", &input);
    ost_haptic_state now, home = at(0, 0, 80, 0);
    (void)state;
    ost_haptic_read(device, &now);
    assert_false(now.lifted);
    home.lifted = true;
    ost_mouse_input_put(input, &home);
    home.lifted = false;
    ost_mouse_input_put(input, &home); /* The state changes to lifted and back to not lifted before the next read. */
    ost_haptic_read(device, &now);
    assert_true(now.lifted && distance_mm(&now.pose, &home.pose) < 0.001);
    ost_haptic_read(device, &now);
    assert_false(now.lifted);
    ost_haptic_close(device);
    ost_mouse_input_free(input);
}

static void invalid_inputs_are_refused(void **state)
{
    ost_error err = {0};
    ost_haptic *device;
    ost_mouse_input *input;
    const ost_haptic_state start = at(0, 0, 0, 0), none = {.tool = 0};
    (void)state;
    assert_int_equal(ost_haptic_open("mouse", NULL, &device, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "needs a window"));
    assert_ok(ost_mouse_input_create(&start, &input, &err));
    assert_int_equal(ost_haptic_open("mouse:speed=3", &(ost_haptic_setup){.mouse = input}, &device, &err),
                     OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("mouse:spin=120", &(ost_haptic_setup){.mouse = input}, &device, &err),
                     OST_ERR_USAGE);
    ost_mouse_input_free(input);
    assert_int_equal(ost_mouse_input_create(&none, &input, &err), OST_ERR_RANGE);
    ost_mouse_input_free(NULL);
}

static double seconds_since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

/* Lets the other thread run. Without this pause, on one core or under valgrind, one thread may use all the time. */
static void yield_to_other_thread(void)
{
    nanosleep(&(const struct timespec){.tv_nsec = 100000}, NULL);
}

/*
 * A thread that sets states. The position in a state is a function of the tool's number, so that
 * a partial state is detected.
 */
typedef struct putter {
    ost_mouse_input *input;
    _Atomic bool stop;
} putter;

static void *put_states(void *user)
{
    putter *p = user;
    for (int i = 0; !atomic_load(&p->stop); i++) {
        const ost_haptic_state s = at(i % 1000, -(i % 1000), 2 * (i % 1000), i % 1000);
        ost_mouse_input_put(p->input, &s);
        if (i % 10000 == 9999)
            yield_to_other_thread();
    }
    return NULL;
}

static void no_partial_state_is_read(void **state)
{
    putter p = {0};
    ost_haptic *device = open_mouse("mouse", &p.input);
    pthread_t thread;
    struct timespec start;
    int32_t last = -1;
    int seen = 0;
    (void)state;
    clock_gettime(CLOCK_MONOTONIC, &start);
    assert_int_equal(pthread_create(&thread, NULL, put_states, &p), 0);
    while (seconds_since(&start) < (seen > 1 ? 0.3 : 20)) {
        ost_haptic_state now;
        ost_haptic_read(device, &now);
        if (now.tool == last) {
            yield_to_other_thread();
            continue;
        }
        last = now.tool;
        seen++;
        const ost_haptic_state complete = at(now.tool, -now.tool, 2 * now.tool, now.tool);
        if (now.tool > 3 && distance_mm(&now.pose, &complete.pose) > 0.001)
            fail_msg("partial state: tool %d with the position (%g, %g, %g) mm", (int)now.tool,
                     (double)now.pose.t.x * 1e-9, (double)now.pose.t.y * 1e-9, (double)now.pose.t.z * 1e-9);
    }
    atomic_store(&p.stop, true);
    pthread_join(thread, NULL);
    assert_true(seen > 1);
    ost_haptic_close(device);
    ost_mouse_input_free(p.input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(device_approaches_the_target),
        cmocka_unit_test(selected_tool_moves_at_once),
        cmocka_unit_test(pedal_is_a_button),
        cmocka_unit_test(lifted_tool_moves_at_once),
        cmocka_unit_test(invalid_inputs_are_refused),
        cmocka_unit_test(no_partial_state_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
