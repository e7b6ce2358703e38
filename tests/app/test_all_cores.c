/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulator reserves one core for the servo loop. Work that ends before this loop starts may also use this core.
 * After this work, the set of cores of the calling thread must be unchanged. The test is skipped on a machine with one
 * core.
 * Covers: REQ-ALL-CORES
 */
#include <sched.h>

#include "harness.h"
#include "src/app/common/all_cores.h"

static void count_cores(void *user)
{
    cpu_set_t set;
    assert_int_equal(sched_getaffinity(0, sizeof set, &set), 0);
    *(int *)user = CPU_COUNT(&set);
}

static void work_runs_on_all_cores(void **state)
{
    (void)state;
    cpu_set_t all, one, after;
    int cores = 0, core = 0;
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    if (CPU_COUNT(&all) < 2)
        skip();
    all_cores_begin();
    while (!CPU_ISSET(core, &all))
        core++;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    all_cores_do(count_cores, &cores);
    assert_int_equal(cores, CPU_COUNT(&all));
    assert_int_equal(sched_getaffinity(0, sizeof after, &after), 0);
    assert_true(CPU_EQUAL(&after, &one));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(work_runs_on_all_cores),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
