/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the failover of a world whose device fails. The failure occurs at a random OpenCL call and
 * is temporary or permanent. The cpu backend or the reference then continues from the last completed
 * tick. The final grid and totals must equal those of a reference that never failed, and every
 * OpenCL object must be released.
 * Covers: REQ-FAILOVER
 */
#include "cl/on_device.h"
#include "cl/shim.h"
#include "ref/scene.h"

#include <osteon/sim.h>

enum { TICKS = 50, ROUNDS = 120 };

typedef struct plan {
    ost_geometry g;
    int16_t *voxels;
    ost_tool_volume tool[2];
    ost_tick ticks[TICKS];
} plan;

static plan make_plan(test_rng *rng)
{
    ost_error err = {0};
    plan p = {.g = cubic_geometry(45, 40, 34, 600 * UM, (ost_pm3){0, 0, 0})};
    p.voxels = random_densities(rng, &p.g, 6);
    for (int t = 0; t < 2; t++) {
        const ost_tool_geometry g = {
            .dims = {9 + t, 8, 10 - t}, .voxel = 600 * UM, .corner = {-2700 * UM, -2400 * UM, 0}};
        assert_ok(ost_tool_volume_init(&p.tool[t], &g, &err));
        for (int64_t v = 0; v < ost_dims_count(g.dims); v++)
            p.tool[t].voxels[v] = (uint8_t)rng_range(rng, 0, 2);
    }
    ost_pm3 at = {13000 * UM, 12000 * UM, 8000 * UM};
    for (int i = 0; i < TICKS; i++) {
        at.x += rng_range(rng, -800, 800) * UM;
        at.y += rng_range(rng, -800, 800) * UM;
        at.z += rng_range(rng, -800, 800) * UM;
        p.ticks[i] = (ost_tick){
            .t_ns = i * INT64_C(1000000), .tool = i / 15 % 2, .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
        p.ticks[i].pose.t = at;
    }
    return p;
}

static void free_plan(plan *p)
{
    for (int t = 0; t < 2; t++)
        ost_tool_volume_free(&p->tool[t]);
    free(p->voxels);
}

typedef struct stage {
    ost_backend *backend;
    ost_bone *bone;
    ost_tool *tools[OST_WORLD_TOOLS_MAX];
    ost_world *world;
} stage;

static stage make_stage(const plan *p, ost_backend *backend, int32_t keep)
{
    ost_error err = {0};
    stage s = {.backend = backend, .bone = bone_of(backend, &p->g, 16, p->voxels)};
    assert_ok(ost_world_create(s.bone, &(ost_world_options){.saved_ticks = keep}, &s.world, &err));
    for (int t = 0; t < 2; t++) {
        assert_ok(ost_tool_upload(backend, &p->tool[t], &s.tools[t], &err));
        assert_ok(ost_world_add_tool(s.world, "tool", s.tools[t], NULL, &err));
    }
    return s;
}

static void free_voxels(stage *s)
{
    for (int t = 0; t < OST_WORLD_TOOLS_MAX; t++)
        ost_tool_free(s->tools[t]);
    ost_bone_free(s->bone);
    ost_backend_close(s->backend);
}

static void continue_ticks(stage *s, const char *spec)
{
    ost_error err = {0};
    stage before = *s;
    assert_ok(ost_backend_open(spec, &s->backend, &err));
    assert_ok(ost_world_failover(s->world, s->backend, &s->bone, s->tools, &err));
    free_voxels(&before);
}

static void failover_after_a_random_failure(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("failover");
    const char *options = strchr(device_spec(), ':') ? strchr(device_spec(), ':') + 1 : "";
    static const enum shim_call calls[] = {SHIM_clEnqueueNDRangeKernel, SHIM_clEnqueueReadBuffer,
                                           SHIM_clEnqueueWriteBuffer,   SHIM_clEnqueueFillBuffer,
                                           SHIM_clSetKernelArg,         SHIM_clCreateBuffer};
    enum { CALLS = sizeof calls / sizeof calls[0] };
    int failures[CALLS] = {0}, late = 0;
    const int rounds = getenv("OST_UNDER_VALGRIND") ? 3 : ROUNDS;
    for (int round = 0; round < rounds; round++) {
        ost_error err = {0};
        ost_backend *ref, *cl;
        plan p = make_plan(&rng);
        assert_ok(ost_backend_open("ref", &ref, &err));
        assert_ok(ost_cl_open_with(&shim, options, &cl, &err));
        cl->ops = &ost_backend_cl;
        stage plain = make_stage(&p, ref, 0), failing = make_stage(&p, cl, (int32_t)rng_range(&rng, 1, 30));
        const int which = round % CALLS;
        const bool lost = rng_range(&rng, 0, 2) > 0;
        /*
         * After the first ticks, all arrays have their final sizes, so only copies of the bone create buffers. There
         * are therefore few calls of clCreateBuffer, and one of the first 8 fails.
         */
        shim_fail(calls[which], (int)rng_range(&rng, 1, which == CALLS - 1 ? 8 : 8 << rng_range(&rng, 0, 5)), lost);
        const char *other = round % 3 ? "cpu:threads=2" : "ref";
        bool moved = false;
        for (int i = 0; i < TICKS; i++) {
            ost_step_result a, b;
            assert_ok(ost_world_step(plain.world, &p.ticks[i], &a, &err));
            ost_status status = ost_world_step(failing.world, &p.ticks[i], &b, &err);
            if (status != OST_OK) {
                if (moved || !shim_failed())
                    fail_msg("tick %d failed without an injected failure, or after the failover: %s", i, err.text);
                assert_non_null(strstr(err.text, "OpenCL device '"));
                continue_ticks(&failing, other);
                moved = true;
                assert_ok(ost_world_step(failing.world, &p.ticks[i], &b, &err));
            }
            assert_int_equal(a.removal, b.removal);
            if (a.removal)
                assert_same_report(a.report, b.report);
        }
        failures[which] += moved;
        ost_world_totals ta, tb;
        ost_world_totals_get(plain.world, &ta);
        ost_world_totals_get(failing.world, &tb);
        assert_memory_equal(&ta, &tb, sizeof ta);
        int16_t *expected = content(plain.bone, &p.g), *got = malloc(voxel_count(&p.g) * sizeof *got);
        assert_non_null(got);
        if (ost_bone_download(failing.bone, 0, p.g.dims.z, got, &err) != OST_OK) {
            assert_true(!moved && shim_failed()); /* In some rounds, the failure occurs only in this download. */
            continue_ticks(&failing, other);
            late++;
            assert_ok(ost_bone_download(failing.bone, 0, p.g.dims.z, got, &err));
        }
        assert_memory_equal(got, expected, voxel_count(&p.g) * sizeof *got);
        ost_digest a = digest_of(plain.bone), b;
        if (ost_bone_digest(failing.bone, NULL, &b, &err) != OST_OK) {
            assert_true(!moved && shim_failed());
            continue_ticks(&failing, other);
            late++;
            b = digest_of(failing.bone);
        }
        assert_memory_equal(&a, &b, sizeof a);
        shim_fail(SHIM_clFinish, 0, false);
        free(expected);
        free(got);
        ost_world_free(plain.world);
        ost_world_free(failing.world);
        free_voxels(&plain);
        free_voxels(&failing);
        free_plan(&p);
        assert_int_equal(shim_alive(), 0);
    }
    int all = late;
    for (int c = 0; c < CALLS; c++) {
        printf("# %s: failed in %d of %d rounds\n", shim_names[calls[c]], failures[c], rounds / CALLS);
        all += failures[c];
    }
    printf("# failures after the last tick: %d\n", late);
    assert_true(all >= rounds / 3);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {cmocka_unit_test(failover_after_a_random_failure)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
