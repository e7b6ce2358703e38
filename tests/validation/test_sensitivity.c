/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mistakes made on purpose: whatever changed a result is found, and where it
 * is; what is right raises no alarm.  And workers that crash, hang or complain
 * are told apart.
 * Covers: REQ-SENSITIVITY
 */
#include "harness.h"

#include "validation/sensitivity.h"
#include "validation/worker.h"

static void proved(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("sensitivity");
    ost_error err = {0};
    sensitivity s;
    const uint64_t seed = rng_next(&rng);
    assert_ok(sensitivity_run(seed, 100, 2, NULL, NULL, &s, &err));
    if (s.first_problem[0])
        fail_msg("%s", s.first_problem);
    assert_int_equal(s.all.injected, 100);
    assert_int_equal(s.false_alarms, 0);
    assert_true(s.clean_runs >= 6);
    assert_true(s.all.changed > 20); /* else nothing was shown */
    assert_int_equal(s.all.detected, s.all.changed);
    assert_int_equal(s.all.located, s.all.changed);
    assert_int_equal(s.all.survived + s.all.changed, s.all.triggered);

    sensitivity one, two;
    assert_ok(sensitivity_run(seed, 40, 1, NULL, NULL, &one, &err));
    assert_ok(sensitivity_run(seed, 40, 3, NULL, NULL, &two, &err));
    assert_memory_equal(&one, &two, sizeof one); /* who runs a scene makes no difference */
}

static worker_result result_of(const char *script, double limit)
{
    ost_error err = {0};
    worker w;
    worker_result r;
    char *argv[] = {(char *)(uintptr_t)"/bin/sh", (char *)(uintptr_t)"-c", (char *)(uintptr_t)script, NULL};
    assert_ok(worker_start(argv, -1, limit, &w, &err));
    assert_ok(worker_wait(&w, &r, &err));
    return r;
}

static void workers(void **state)
{
    (void)state;
    worker_result r = result_of("exit 0", 60);
    assert_int_equal(r.end, WORKER_DONE);
    r = result_of("echo first >&2; echo the reason >&2; exit 3", 60);
    assert_int_equal(r.end, WORKER_FAILED);
    assert_int_equal(r.code, 3);
    assert_string_equal(r.text, "the reason");
    r = result_of("kill -SEGV $$", 60);
    assert_int_equal(r.end, WORKER_CRASHED);
    assert_int_equal(r.code, 11);
    r = result_of("exec sleep 60", 0.2);
    assert_int_equal(r.end, WORKER_LATE);
    /* A line without end does not grow. */
    r = result_of("head -c 100000 /dev/zero | tr '\\0' x >&2; exit 2", 60);
    assert_int_equal(r.end, WORKER_FAILED);
    assert_int_equal(strlen(r.text), sizeof r.text - 1);

    ost_error err = {0};
    worker w;
    char *nothing[] = {(char *)(uintptr_t)"/nowhere/osteon", NULL};
    assert_int_equal(worker_start(nothing, -1, 60, &w, &err), OST_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(proved),
        cmocka_unit_test(workers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
