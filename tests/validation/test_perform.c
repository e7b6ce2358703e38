/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a case on backends that lack functions and on backends whose functions fail. A record may be
 * excluded from the comparison only if a function is missing. Each backend is the reference with one slot
 * changed, and is compared with the unchanged reference.
 * Covers: REQ-EVIDENCE
 */
#include "harness.h"
#include "io/scratch_group.h"

#include "core/backend.h"
#include "validation/compare.h"
#include "validation/perform.h"

/* Fails as if the device were lost. A missing function causes the same status. */
static ost_status lost_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    (void)bone, (void)z0, (void)count, (void)voxels;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "the device was lost");
}

static ost_status lost_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                              ost_error *err)
{
    (void)bone, (void)count, (void)at, (void)densities;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "the device was lost");
}

static ost_status lost_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                 ost_error *err)
{
    (void)bone, (void)count, (void)chunks, (void)words;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "the device was lost");
}

/* Performs the case on the reference with the functions in `ops`, and opens the trace of this run. */
static void perform_with(const ost_backend_ops *ops, const scene *s, const char *name, trace *out)
{
    ost_error err = {0}, why = {0};
    char path[4200];
    ost_backend *backend;
    trace_writer *w;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_ok(ost_backend_open("ref", &backend, &err));
    const ost_backend_ops *own = backend->ops;
    backend->ops = ops ? ops : own;
    assert_ok(trace_create(path, &w, &err));
    assert_ok(perform(backend, s, 0, w, NULL, NULL, &why, &err));
    assert_ok(trace_close(w, &err));
    assert_ok(trace_open(path, out, &err));
    backend->ops = own;
    ost_backend_close(backend);
}

static const ost_backend_ops *slots_of_reference(void)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open("ref", &backend, &err));
    const ost_backend_ops *ops = backend->ops;
    ost_backend_close(backend);
    return ops;
}

static void failing_function_is_not_missing(void **state)
{
    const plan_case c = {.family = PLAN_IMPORT, .number = 0, .tier = PLAN_SMOKE, .seed = 1, .id = "import/0"};
    const ost_backend_ops *own = slots_of_reference();
    ost_backend_ops lacks = *own, samples = *own, occupies = *own, uploads = *own;
    ost_error err = {0};
    compare_difference d;
    scene s;
    trace reference, got;
    (void)state;
    lacks.bone_sample = ost_no_sample;
    lacks.bone_occupancy = ost_no_occupancy;
    samples.bone_sample = lost_sample;
    occupies.bone_occupancy = lost_occupancy;
    uploads.bone_upload = lost_upload;
    const struct {
        const ost_backend_ops *ops;
        bool equal;
        trace_stage stage;
        uint32_t item;
    } rows[] = {
        {own, true, TRACE_CASE, 0},
        {&lacks, true, TRACE_CASE, 0},
        {&samples, false, TRACE_SAMPLE, 0},
        {&occupies, false, TRACE_SAMPLE, 1},
        {&uploads, false, TRACE_UPLOAD, 0},
    };
    assert_ok(scene_make(&c, &s, &err));
    perform_with(NULL, &s, "reference", &reference);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        perform_with(rows[i].ops, &s, "other", &got);
        compare_case(&reference, compare_find(&reference, 0), &got, compare_find(&got, 0), &d);
        assert_int_equal(d.kind == COMPARE_EQUAL, rows[i].equal);
        if (!rows[i].equal) {
            assert_int_equal(d.stage, rows[i].stage);
            assert_int_equal(d.item, rows[i].item);
        }
        trace_free(&got);
    }
    trace_free(&reference);
    scene_free(&s);
}

/*
 * Before the ticks, `perform` collides each tool with a bone whose spacing is derived from the size
 * of the tool's voxels. This spacing must be valid even for the smallest tool voxels.
 */
static void smallest_tool_voxels_are_accepted(void **state)
{
    /* with seed 1, the tools of these cases have voxels smaller than 4 * OST_SPACING_MIN */
    static const int numbers[] = {9, 17, 27, 36};
    (void)state;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        plan_case c = {.family = PLAN_SMALL, .number = numbers[i], .tier = PLAN_SMOKE, .seed = 1};
        char path[4200];
        ost_backend *backend;
        trace_writer *w;
        ost_error err = {0}, why = {0};
        scene s;
        snprintf(c.id, sizeof c.id, "small/%d", numbers[i]);
        snprintf(path, sizeof path, "%s/finest", folder);
        assert_ok(scene_make(&c, &s, &err));
        assert_ok(ost_backend_open("ref", &backend, &err));
        assert_ok(trace_create(path, &w, &err));
        assert_ok(perform(backend, &s, 0, w, NULL, NULL, &why, &err));
        assert_string_equal(why.text, "");
        assert_ok(trace_close(w, &err));
        ost_backend_close(backend);
        scene_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(failing_function_is_not_missing),
                                       cmocka_unit_test(smallest_tool_voxels_are_accepted)};
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
