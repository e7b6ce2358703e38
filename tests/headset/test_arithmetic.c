/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the arithmetic of a headset. A point that is projected by the matrix of the OpenXR specification must be at the
 * pixel that is computed from the eye's focal length and axis. A pose in the room must be at the right position in the
 * bone's frame. Covers: REQ-HEADSET
 */
#include <math.h>

#include "harness.h"
#include "haptics/driver.h"
#include "haptics/hand.h"
#include "headset/projection.h"
#include "headset/room.h"

static double real(test_rng *rng, double lo, double hi)
{
    return lo + (hi - lo) * (double)rng_range(rng, 0, 1000000) / 1e6;
}

/* Computes the clip coordinates of the point (x, y, -1) with the usual asymmetric projection matrix of four angles. */
static void clip_of(const ost_headset_fov *fov, double x, double y, double out[2])
{
    const double left = tan(fov->left), right = tan(fov->right), up = tan(fov->up), down = tan(fov->down);
    const double m00 = 2 / (right - left), m02 = (right + left) / (right - left), m11 = 2 / (up - down),
                 m12 = (up + down) / (up - down);
    out[0] = m00 * x - m02;
    out[1] = m11 * y - m12;
}

static void projection_equals_openxr_matrix(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("projections");
    for (int i = 0; i < 20000; i++) {
        const ost_headset_fov fov = {real(&rng, -1.2, 0.2), real(&rng, 0.3, 1.2), real(&rng, 0.3, 1.2),
                                     real(&rng, -1.2, 0.2)};
        const int width = (int)rng_range(&rng, 200, 3000), height = (int)rng_range(&rng, 200, 3000);
        ost_headset_projection p;
        double clip[2];
        assert_true(ost_headset_project(&fov, width, height, &p));
        /* The picture must cover all given angles. Along at least one axis, it must not extend beyond them. */
        assert_true(p.fov.left <= fov.left + 1e-12 && p.fov.right >= fov.right - 1e-12);
        assert_true(p.fov.up >= fov.up - 1e-12 && p.fov.down <= fov.down + 1e-12);
        const double wider = tan(p.fov.right) - tan(p.fov.left) - tan(fov.right) + tan(fov.left),
                     higher = tan(p.fov.up) - tan(p.fov.down) - tan(fov.up) + tan(fov.down);
        assert_true(fmin(wider, higher) < 2e-5 * (tan(fov.right) - tan(fov.left) + tan(fov.up) - tan(fov.down)));
        const double x = real(&rng, -2, 2), y = real(&rng, -2, 2), focal = p.focal_milli / 1000.0;
        clip_of(&p.fov, x, y, clip);
        assert_true(fabs((clip[0] + 1) / 2 * width - (p.middle[0] + focal * x)) < 1e-6);
        assert_true(fabs((1 - clip[1]) / 2 * height - (p.middle[1] - focal * y)) < 1e-6);
    }
}

static void symmetric_view_has_centred_axis(void **state)
{
    (void)state;
    const double a = atan(0.5);
    const ost_headset_fov fov = {-a, a, a, -a};
    ost_headset_projection p;
    assert_true(ost_headset_project(&fov, 640, 480, &p));
    assert_int_equal(p.focal_milli, 480000);
    assert_true(fabs(p.middle[0] - 320) < 1e-9 && fabs(p.middle[1] - 240) < 1e-9);
}

static void unusable_angles_are_refused(void **state)
{
    (void)state;
    const ost_headset_fov bad[] = {{NAN, 1, 1, -1}, {-1, INFINITY, 1, -1}, {-1, 1, 1.6, -1}, {-1, 1, 1, -1.5},
                                   {1, -1, 1, -1},  {-1, 1, -1, 1},        {-1, -1, 1, -1},  {0, 0, 0, 0}};
    ost_headset_projection p;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(ost_headset_project(&bad[i], 640, 480, &p));
    const ost_headset_fov good = {-1, 1, 1, -1};
    assert_false(ost_headset_project(&good, 1, 1, &p)); /* The focal length would be less than a pixel. */
}

/* The direction of view is -x, and z is up. Therefore right is y, up is z, and back is x. */
static const double RIGHT[3] = {0, 1, 0}, UP[3] = {0, 0, 1}, BACK[3] = {1, 0, 0}, AT[3] = {10, 20, 30};

static void target_is_half_a_metre_ahead(void **state)
{
    (void)state;
    const ost_room room = ost_room_make(AT, RIGHT, UP, BACK);
    const double ahead[3] = {0, 0, -0.5}, eyes[3] = {0, 0, 0}, aside[3] = {0.1, 0.2, -0.5}, none[4] = {1, 0, 0, 0};
    ost_error err = {0};
    ost_pose pose;
    assert_ok(ost_room_pose(&room, ahead, none, &pose, &err));
    assert_int_equal(pose.t.x, 10 * OST_PM_PER_MM);
    assert_int_equal(pose.t.y, 20 * OST_PM_PER_MM);
    assert_int_equal(pose.t.z, 30 * OST_PM_PER_MM);
    assert_ok(ost_room_pose(&room, eyes, none, &pose, &err));
    assert_true(llabs(pose.t.x - 510 * OST_PM_PER_MM) < 1000);
    assert_ok(ost_room_pose(&room, aside, none, &pose, &err));
    assert_true(llabs(pose.t.y - 120 * OST_PM_PER_MM) < 1000 && llabs(pose.t.z - 230 * OST_PM_PER_MM) < 1000);
}

/* An orientation is given relative to the room. It must rotate the room's axes to the axes of the pose. */
static void orientations_are_converted_to_bone_frame(void **state)
{
    (void)state;
    const ost_room room = ost_room_make(AT, RIGHT, UP, BACK);
    const double at[3] = {0, 0, 0}, h = sqrt(0.5), about_y[4] = {h, 0, h, 0}; /* rotates z to x, and x to -z */
    ost_error err = {0};
    ost_pose pose;
    double mm[3], q[4];
    assert_ok(ost_room_pose(&room, at, about_y, &pose, &err));
    ost_pose_to_doubles(&pose, mm, q);
    /* The third column of the rotation is the pose's z axis. This is the room's x axis, which is the bone's y axis. */
    const double z[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                         1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    assert_true(fabs(z[0]) < 1e-6 && fabs(z[1] - 1) < 1e-6 && fabs(z[2]) < 1e-6);
}

static void bad_poses_are_refused(void **state)
{
    (void)state;
    const ost_room room = ost_room_make(AT, RIGHT, UP, BACK);
    const double far[3] = {0, 9, 0}, not[3] = {NAN, 0, 0}, at[3] = {0}, none[4] = {1, 0, 0, 0}, zero[4] = {0},
                 nans[4] = {NAN, 0, 0, 0}, nearly[4] = {1.001, 0, 0, 0};
    ost_error err = {0};
    ost_pose pose;
    assert_int_equal(ost_room_pose(&room, far, none, &pose, &err), OST_ERR_RANGE);
    assert_int_equal(ost_room_pose(&room, not, none, &pose, &err), OST_ERR_RANGE);
    assert_int_equal(ost_room_pose(&room, at, zero, &pose, &err), OST_ERR_RANGE);
    assert_int_equal(ost_room_pose(&room, at, nans, &pose, &err), OST_ERR_RANGE);
    assert_ok(ost_room_pose(&room, at, nearly, &pose, &err));
}

/* ------------------------------------------------------------------- device */

static ost_pose at_mm(int x)
{
    ost_pose pose = ost_pose_identity();
    pose.t.x = x * OST_PM_PER_MM;
    return pose;
}

static void device_follows_hand(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_hand_input *input;
    ost_haptic *device;
    ost_haptic_state s = {0};
    assert_ok(ost_hand_input_create(&input, &err));
    const ost_haptic_setup setup = {.hand = input, .start = ost_pose_identity()};
    assert_ok(ost_haptic_open("openxr:hand=left", &setup, &device, &err));
    assert_true(ost_hand_input_is_left(input));
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_NOT_TRACKED);

    /* When a hand appears, the tool must move to it at once and be reported as lifted. */
    ost_hand_input_put(input, &(ost_hand_sample){true, at_mm(500), OST_HAND_TRIGGER});
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    assert_true(s.lifted && s.pose.t.x == 500 * OST_PM_PER_MM && s.buttons == OST_HAND_TRIGGER && s.tool == -1);

    /* When the hand moves, the tool must follow in small steps until it reaches the hand. */
    ost_hand_input_put(input, &(ost_hand_sample){true, at_mm(600), 0});
    int64_t last = s.pose.t.x;
    for (int i = 0; i < 400; i++) {
        assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
        assert_true(!s.lifted && s.pose.t.x >= last && s.pose.t.x - last <= OST_PM_PER_MM + 1);
        last = s.pose.t.x;
    }
    assert_true(llabs(last - 600 * OST_PM_PER_MM) < OST_PM_PER_MM / 1000);

    /* When a lost hand appears again, the tool must move to it without a sweep. */
    ost_hand_input_put(input, &(ost_hand_sample){.tracked = false});
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_NOT_TRACKED);
    ost_hand_input_put(input, &(ost_hand_sample){true, at_mm(0), 0});
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    assert_true(s.lifted && s.pose.t.x == 0);
    ost_haptic_close(device);
    ost_hand_input_free(input);
}

static void invalid_device_options_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_hand_input *input;
    ost_haptic *device;
    assert_ok(ost_hand_input_create(&input, &err));
    const ost_haptic_setup setup = {.hand = input, .start = ost_pose_identity()};
    assert_int_equal(ost_haptic_open("openxr", NULL, &device, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "--headset"));
    assert_int_equal(ost_haptic_open("openxr:hand=both", &setup, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("openxr:scale=3", &setup, &device, &err), OST_ERR_USAGE);
    ost_hand_input_free(input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projection_equals_openxr_matrix),
        cmocka_unit_test(symmetric_view_has_centred_axis),
        cmocka_unit_test(unusable_angles_are_refused),
        cmocka_unit_test(target_is_half_a_metre_ahead),
        cmocka_unit_test(orientations_are_converted_to_bone_frame),
        cmocka_unit_test(bad_poses_are_refused),
        cmocka_unit_test(device_follows_hand),
        cmocka_unit_test(invalid_device_options_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
