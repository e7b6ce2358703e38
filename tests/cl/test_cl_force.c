/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the force while a device removes bone. The backends cl and ref perform the same operation: a hand presses a
 * rotating tool into bone. In each tick, the force is computed, and the tool's pose is passed to the world, which
 * removes bone. A difference in one sampled voxel would change the force, the tool's pose and all later ticks.
 * Therefore all forces, all reports and the final grids must be equal.
 * Covers: REQ-CL-FORCE
 */
#include "cl/on_device.h"
#include "ref/scene.h"

#include <osteon/force.h>
#include <osteon/sim.h>

enum { TICKS = 250, TOOL = 16 };
#define PERIOD_S 1e-3

typedef struct side {
    ost_backend *backend;
    ost_bone *bone;
    ost_tool *tool;
    ost_world *world;
    ost_force *force;
} side;

static ost_tool_volume ball(void)
{
    ost_error err = {0};
    ost_tool_volume volume;
    const ost_pm voxel = 500 * UM;
    const ost_tool_geometry g = {{TOOL, TOOL, TOOL}, voxel, {-TOOL * voxel / 2, -TOOL * voxel / 2, -TOOL * voxel / 2}};
    assert_ok(ost_tool_volume_init(&volume, &g, &err));
    for (int z = 0; z < TOOL; z++)
        for (int y = 0; y < TOOL; y++)
            for (int x = 0; x < TOOL; x++) {
                const int a = 2 * x + 1 - TOOL, b = 2 * y + 1 - TOOL, c = 2 * z + 1 - TOOL;
                volume.voxels[x + TOOL * (y + TOOL * z)] =
                    a * a + b * b + c * c <= TOOL * TOOL ? OST_TOOL_CUTTING : OST_TOOL_VOID;
            }
    return volume;
}

static side make_side(const char *spec, const ost_geometry *g, int chunk, const int16_t *voxels, ost_force_mode mode)
{
    ost_error err = {0};
    side s;
    ost_force_params params = ost_force_defaults();
    params.mode = mode;
    params.energy = 2e6; /* The bone is soft, so that the tool advances through several chunks. */
    ost_tool_volume tool = ball();
    assert_ok(ost_backend_open(spec, &s.backend, &err));
    s.bone = bone_of(s.backend, g, chunk, voxels);
    assert_ok(ost_tool_upload(s.backend, &tool, &s.tool, &err));
    assert_ok(ost_world_create(s.bone, NULL, &s.world, &err));
    assert_ok(ost_world_add_tool(s.world, "ball", s.tool, NULL, &err));
    assert_ok(ost_force_create(s.bone, &params, &s.force, &err));
    assert_ok(ost_force_add_tool(s.force, s.tool, &err));
    ost_tool_volume_free(&tool);
    return s;
}

static void free_side(side *s)
{
    ost_force_free(s->force);
    ost_world_free(s->world);
    ost_tool_free(s->tool);
    ost_bone_free(s->bone);
    ost_backend_close(s->backend);
}

/* Advances one side by one tick. */
static ost_step_result advance(side *s, const ost_pose *hand, int64_t number, ost_force_result *felt)
{
    ost_error err = {0};
    ost_step_result step;
    memset(felt, 0, sizeof *felt);
    assert_ok(ost_force_step(s->force, 0, hand, PERIOD_S, felt, &err));
    const ost_tick tick = {.t_ns = number * 1000000, .rpm = OST_RPM_ON, .pose = felt->tool};
    assert_ok(ost_world_step(s->world, &tick, &step, &err));
    return step;
}

static void press(const char *kernels, int chunk, ost_force_mode mode)
{
    char spec[200];
    const ost_geometry g = cubic_geometry(60, 50, 70, 500 * UM, (ost_pm3){0, 0, 0});
    test_rng rng = rng_seeded(kernels);
    int16_t *voxels = random_densities(&rng, &g, 7);
    spec_with(spec, sizeof spec, kernels);
    side ref = make_side("ref", &g, chunk, voxels, mode), cl = make_side(spec, &g, chunk, voxels, mode);
    uint64_t removed = 0;
    int touching = 0;
    /* The hand moves from outside the bone deep into the bone, obliquely to the bone's axes. */
    ost_pose hand = ost_pose_identity();
    hand.t = (ost_pm3){8000 * UM, 7000 * UM, -5000 * UM};
    for (int i = 0; i < TICKS; i++) {
        ost_force_result a, b;
        hand.t.x += 40 * UM;
        hand.t.y += 30 * UM;
        hand.t.z += 120 * UM;
        const ost_step_result x = advance(&ref, &hand, i, &a), y = advance(&cl, &hand, i, &b);
        if (memcmp(&a, &b, sizeof a) != 0)
            fail_msg("tick %d: ref has %d points in contact and %g N along z; cl has %d points and %g N", i, a.touching,
                     a.force_n[2], b.touching, b.force_n[2]);
        assert_int_equal(x.removal, y.removal);
        if (x.removal) {
            assert_same_report(x.report, y.report);
            removed += x.report->total_voxels;
        }
        touching += a.touching > 0;
    }
    assert_true(touching > TICKS / 2);
    assert_true(removed > 1000);
    const ost_digest a = digest_of(ref.bone), b = digest_of(cl.bone);
    assert_memory_equal(&a, &b, sizeof a);
    free_side(&ref);
    free_side(&cl);
    free(voxels);
}

static void force_equals_the_reference(void **state)
{
    (void)state;
    for (int chunk = 16; chunk <= 64; chunk *= 2) {
        press("kernels=cpu", chunk, OST_FORCE_ENERGY);
        press("kernels=gpu", chunk, OST_FORCE_ENERGY);
    }
    press("kernels=cpu", 32, OST_FORCE_INSTANT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_equals_the_reference),
    };
    const int missing = device_missing();
    return missing ? missing : cmocka_run_group_tests(tests, NULL, NULL);
}
