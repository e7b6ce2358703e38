/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the detection of deliberate mistakes: every mistake that changed a result must be detected and
 * located, and correct results must cause no alarm. Crashed workers, hung workers and workers that report
 * errors must be distinguished.
 * Covers: REQ-SENSITIVITY
 */
#include "harness.h"

#include <unistd.h>

#include "validation/bundle/faults.h"
#include "validation/compare.h"
#include "validation/dense/dense.h"
#include "validation/perform.h"
#include "validation/scratch.h"
#include "validation/sensitivity.h"
#include "validation/worker.h"

static void mistakes_are_detected(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("sensitivity");
    ost_error err = {0};
    sensitivity s;
    const uint64_t seed = rng_next(&rng);
    assert_ok(sensitivity_run(seed, DEVIATION_KINDS - 1, 2, NULL, NULL, &s, &err));
    if (s.first_problem[0])
        fail_msg("%s", s.first_problem);
    /*
     * In the smoke tier, each kind of mistake is made once. A kind that changed no result is made in four more scenes.
     */
    assert_int_equal(sensitivity_injections(PLAN_SMOKE), DEVIATION_KINDS - 1);
    assert_true(s.all.injected >= DEVIATION_KINDS - 1);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++)
        assert_true(s.of[k].changed ? s.of[k].injected >= 1 : s.of[k].injected == 5);
    assert_int_equal(s.false_alarms, 0);
    assert_true(s.clean_runs >= 4);
    /* for seven seeds, 58 to 61 kinds of mistakes changed a result; the other kinds need a rare scene */
    assert_true(s.kinds_changed >= 50);
    assert_int_equal(s.kinds_noticed, s.kinds_changed);
    assert_int_equal(s.all.detected, s.all.changed);
    assert_int_equal(s.all.located, s.all.changed);
    assert_int_equal(s.all.survived + s.all.changed, s.all.triggered);

    sensitivity one, two;
    assert_ok(sensitivity_run(seed, 24, 1, NULL, NULL, &one, &err));
    assert_ok(sensitivity_run(seed, 24, 3, NULL, NULL, &two, &err));
    /* Checks that the result does not depend on the thread that runs a scene. */
    /* the last member is followed by padding, which is not initialized */
    assert_memory_equal(&one, &two, offsetof(sensitivity, first_problem));
    assert_string_equal(one.first_problem, two.first_problem);
}

/*
 * Some kinds of mistakes change a result only in a special scene. The scenes must include such a
 * scene, the mistake must be made there, and the changed results must be found.
 */
static void rare_kinds_are_triggered(void **state)
{
    static const deviation_kind rare[] = {DEVIATION_CONTRACTED_MULTIPLY_ADD,
                                          DEVIATION_NARROW_AREA,
                                          DEVIATION_MUL24,
                                          DEVIATION_TRUNCATED_NEGATIVE,
                                          DEVIATION_BORDER_INCLUDED,
                                          DEVIATION_WRONG_MAP_ROUNDING,
                                          DEVIATION_FLOAT_BASE,
                                          DEVIATION_TRUNCATED_STEP,
                                          DEVIATION_WRAPPED_FAR_BLOCK,
                                          DEVIATION_FREED_TOO_EARLY};
    enum { SEEDS = 4 };
    uint64_t changed[DEVIATION_KINDS] = {0};
    size_t missing = 1;
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS && missing; seed++) {
        ost_error err = {0};
        sensitivity s;
        assert_ok(sensitivity_run(seed, DEVIATION_KINDS - 1, 2, NULL, NULL, &s, &err));
        if (s.first_problem[0])
            fail_msg("%s", s.first_problem);
        assert_int_equal(s.all.located, s.all.changed);
        missing = 0;
        for (size_t k = 0; k < sizeof rare / sizeof rare[0]; k++) {
            changed[rare[k]] += s.of[rare[k]].changed;
            missing += changed[rare[k]] == 0;
        }
    }
    for (size_t k = 0; k < sizeof rare / sizeof rare[0]; k++)
        if (!changed[rare[k]])
            fail_msg("%s changed no result with %d seeds", deviation_describe(rare[k])->name, SEEDS);
}

/*
 * The sentence of the verdict must contain the number of kinds, the place where the mistakes were made, and
 * the number of kinds that changed no result.
 */
static void statement_contains_counts(void **state)
{
    (void)state;
    char text[FAULTS_STATEMENT];
    sensitivity s = {.kinds_changed = DEVIATION_KINDS - 1 - 15, .kinds_noticed = DEVIATION_KINDS - 1 - 16};
    faults_statement(&s, text);
    char expected[FAULTS_STATEMENT];
    snprintf(expected, sizeof expected,
             "%d of %d kinds of deliberate mistakes, made in the second implementation (validation/dense) and in no "
             "backend, were detected; "
             "15 kinds changed nothing in this tier",
             DEVIATION_KINDS - 17, DEVIATION_KINDS - 1);
    assert_string_equal(text, expected);
    s = (sensitivity){.kinds_changed = DEVIATION_KINDS - 1, .kinds_noticed = DEVIATION_KINDS - 1};
    faults_statement(&s, text);
    assert_null(strstr(text, "changed nothing"));
}

static void trace_of(ost_backend *backend, const scene *s, int fd, trace *out)
{
    ost_error err = {0}, why;
    trace_writer *w;
    char name[SCRATCH_NAME];
    scratch_name(fd, name);
    assert_ok(trace_create(name, &w, &err));
    assert_ok(perform(backend, s, 0, w, NULL, NULL, &why, &err));
    trace_begin(w, TRACE_END, 1, 0);
    assert_ok(trace_end(w, &err));
    assert_ok(trace_close(w, &err));
    assert_ok(trace_open(name, out, &err));
}

/*
 * For any seed, a case of the smoke tier must detect a resampling that is wrong only at positions exactly on
 * a source layer.
 */
static void smoke_detects_error_at_exact_layers(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("exact multiples");
    ost_error err = {0};
    ost_backend *ref;
    int files[2];
    for (int f = 0; f < 2; f++)
        assert_ok(scratch_file(&files[f], &err));
    assert_ok(ost_backend_open("ref", &ref, &err));
    for (int round = 0; round < 2; round++) {
        const uint64_t seed = round ? rng_next(&rng) >> 1 : 1;
        int differ = 0;
        plan p;
        assert_ok(plan_make(PLAN_SMOKE, seed, 1, 1, "import", NULL, &p, &err));
        for (int i = 0; i < p.count; i++) {
            const deviation how = {DEVIATION_MULTIPLE_OFF_BY_ONE, 1, 1};
            ost_backend *other;
            scene s;
            trace right = {0}, wrong = {0};
            compare_difference d;
            assert_ok(scene_make(&p.cases[i], &s, &err));
            assert_ok(dense_open(&how, &other, &err));
            trace_of(ref, &s, files[0], &right);
            trace_of(other, &s, files[1], &wrong);
            compare_case(&right, compare_find(&right, 0), &wrong, compare_find(&wrong, 0), &d);
            differ += d.kind == COMPARE_VOXEL && d.stage == TRACE_CUBIC;
            assert_true(d.kind == COMPARE_EQUAL || d.stage == TRACE_CUBIC || d.stage == TRACE_RESAMPLE);
            trace_free(&right);
            trace_free(&wrong);
            ost_backend_close(other);
            scene_free(&s);
        }
        print_message("# seed %llu: the mistake was detected in %d of %d cases\n", (unsigned long long)seed, differ,
                      p.count);
        assert_true(differ > 0);
        plan_free(&p);
    }
    ost_backend_close(ref);
    for (int f = 0; f < 2; f++)
        close(files[f]);
}

static worker_result result_of(const char *script, double limit)
{
    ost_error err = {0};
    worker w;
    worker_result r;
    char *argv[] = {(char *)(uintptr_t)"/bin/sh", (char *)(uintptr_t)"-c", (char *)(uintptr_t)script, NULL};
    assert_ok(worker_start(argv, -1, -1, limit, &w, &err));
    assert_ok(worker_wait(&w, &r, &err));
    return r;
}

static void outcomes_of_workers(void **state)
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
    /* A worker that prints an endless line must not increase the memory use. */
    r = result_of("head -c 100000 /dev/zero | tr '\\0' x >&2; exit 2", 60);
    assert_int_equal(r.end, WORKER_FAILED);
    assert_int_equal(strlen(r.text), sizeof r.text - 1);

    ost_error err = {0};
    worker w;
    char *nothing[] = {(char *)(uintptr_t)"/nowhere/osteon", NULL};
    assert_int_equal(worker_start(nothing, -1, -1, 60, &w, &err), OST_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mistakes_are_detected),
        cmocka_unit_test(statement_contains_counts),
        cmocka_unit_test(rare_kinds_are_triggered),
        cmocka_unit_test(smoke_detects_error_at_exact_layers),
        cmocka_unit_test(outcomes_of_workers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
