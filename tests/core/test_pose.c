/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that poses are quantised once, rounding half to even, and that invalid poses are
 * refused.
 * Covers: AR-POSE-1, AR-POSE-2, AR-POSE-3
 */
#include "harness.h"

#include <osteon/pose.h>

static void doubles_are_quantised(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_pose pose;
    assert_ok(ost_pose_from_doubles((double[]){0.1, -57.34, 8000}, (double[]){0.5, -0.5, 0.5, 0.5}, &pose, &err));
    assert_int_equal(pose.t.x, 100000000);
    assert_int_equal(pose.t.y, INT64_C(-57340000000));
    assert_int_equal(pose.t.z, OST_LENGTH_MAX);
    assert_int_equal(pose.qw, 1 << 29);
    assert_int_equal(pose.qx, -(1 << 29));
    /*
     * A double represents its shortest decimal (AR-POSE-2, AR-LEN-4). The decimals here are not ties,
     * although the binary fractions are. In units of 2^-30: 1 + 2^-31 = 1.00000000046566128730… represents
     * 1.0000000004656613, which is above 2^30 + 1/2; 1 - 2^-31 = 0.99999999953433871269… represents
     * 0.9999999995343387, which is below 2^30 - 1/2; 1 + 3 * 2^-31 = 1.00000000139698386191… represents
     * 1.0000000013969839, which is above 2^30 + 3/2.
     */
    assert_ok(ost_pose_from_doubles((double[]){0, 0, 0}, (double[]){1 + 0x1p-31, 0, 0, 0}, &pose, &err));
    assert_int_equal(pose.qw, OST_Q30_ONE + 1);
    assert_ok(ost_pose_from_doubles((double[]){0, 0, 0}, (double[]){1 - 0x1p-31, 0, 0, 0}, &pose, &err));
    assert_int_equal(pose.qw, OST_Q30_ONE - 1);
    assert_ok(ost_pose_from_doubles((double[]){0, 0, 0}, (double[]){1 + 0x3p-31, 0, 0, 0}, &pose, &err));
    assert_int_equal(pose.qw, OST_Q30_ONE + 2);
}

static void bad_poses_are_refused(void **state)
{
    (void)state;
    const double nan = strtod("nan", NULL);
    ost_pose pose = ost_pose_identity();
    const double zero[3] = {0, 0, 0};
    const double one[4] = {1, 0, 0, 0};
    assert_int_equal(ost_pose_from_doubles((double[]){nan, 0, 0}, one, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles((double[]){0, 8000.1, 0}, one, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){nan, 0, 0, 0}, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){0, 0, 0, 0}, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){2, 0, 0, 0}, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){1.00101, 0, 0, 0}, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){0.99899, 0, 0, 0}, &pose, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){1.00099, 0, 0, 0}, &pose, NULL), OST_OK);
    assert_int_equal(ost_pose_from_doubles(zero, (double[]){0.99901, 0, 0, 0}, &pose, NULL), OST_OK);
}

static void decimals_and_doubles_agree(void **state)
{
    (void)state;
    ost_error err = {0};
    const char *const text[7] = {"0.1", "-2.5", "3", "0.8", "0.6", "0", "-0"};
    ost_decimal d[7];
    for (int i = 0; i < 7; i++)
        assert_non_null(ost_decimal_read(text[i], text[i] + strlen(text[i]), &d[i]));
    ost_pose a, b;
    assert_ok(ost_pose_from_decimals(d, d + 3, &a, &err));
    assert_ok(ost_pose_from_doubles((double[]){0.1, -2.5, 3}, (double[]){0.8, 0.6, 0, -0.0}, &b, &err));
    assert_memory_equal(&a, &b, sizeof a);
    /* RHE(0.8 * 2^30) = RHE(858993459.2) */
    assert_int_equal(a.qw, 858993459);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doubles_are_quantised),
        cmocka_unit_test(bad_poses_are_refused),
        cmocka_unit_test(decimals_and_doubles_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
