/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The comparison of a metric with its closed-form value.
 */
#ifndef OST_TESTS_METRICS_NEAR_H
#define OST_TESTS_METRICS_NEAR_H

#include "harness.h"

#include <math.h>

#include <osteon/metrics.h>

#define MM OST_PM_PER_MM
#define PI 3.14159265358979323846

#define NEAR(value, expected, bound)                                                              \
    do {                                                                                          \
        print_message("%-24s %9.3f, expected %9.3f\n", #value, (double)(value), (double)(expected)); \
        assert_true(fabs((double)(value) - (expected)) <= (bound));                               \
    } while (0)

#endif
