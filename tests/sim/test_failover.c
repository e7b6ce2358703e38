/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests failover. A world that is moved between two backends at random ticks must have the same
 * grid and totals as a world that is not moved.
 * Covers: REQ-FAILOVER
 */
#include "ref/scene.h"

#include <osteon/sim.h>

enum { TICKS = 60, TOOLS = 2 };

typedef struct plan {
    ost_geometry g;
    int16_t *voxels;
    ost_tick ticks[TICKS];
    ost_world_options options;
} plan;

static plan make_plan(test_rng *rng)
{
    plan p = {.g = cubic_geometry((int32_t)rng_range(rng, 20, 50), (int32_t)rng_range(rng, 20, 40), 30, 700 * UM,
                                  (ost_pm3){5, -7, 0})};
    p.voxels = random_densities(rng, &p.g, 7);
    p.options = (ost_world_options){.removal_period_ns = rng_range(rng, 0, 1) * 3000000,
                                    .sweep_off = rng_range(rng, 0, 3) == 0};
    ost_pm3 at = {10000 * UM, 10000 * UM, 10000 * UM};
    int32_t tool = 0;
    for (int i = 0; i < TICKS; i++) {
        at.x += rng_range(rng, -900, 900) * UM;
        at.y += rng_range(rng, -900, 900) * UM;
        at.z += rng_range(rng, -900, 900) * UM;
        tool = rng_range(rng, 0, 9) == 0 ? 1 - tool : tool;
        p.ticks[i] = (ost_tick){
            .t_ns = i * INT64_C(1000000), .tool = tool, .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
        p.ticks[i].pose.t = at;
    }
    return p;
}

/* A world, its bone and its tools on one backend. A tool is added to the world at the tool's first tick. */
typedef struct stage {
    ost_bone *bone;
    ost_tool *tools[OST_WORLD_TOOLS_MAX];
    ost_world *world;
    int count;
} stage;

static stage make_stage(const plan *p, ost_backend *backend, int32_t keep, const ost_tool_volume *volumes)
{
    ost_error err = {0};
    stage s = {.bone = bone_of(backend, &p->g, 16, p->voxels)};
    ost_world_options options = p->options;
    options.saved_ticks = keep;
    assert_ok(ost_world_create(s.bone, &options, &s.world, &err));
    for (int t = 0; t < TOOLS; t++)
        assert_ok(ost_tool_upload(backend, &volumes[t], &s.tools[t], &err));
    assert_ok(ost_world_add_tool(s.world, "first", s.tools[0], NULL, &err));
    s.count = 1;
    return s;
}

static void free_voxels(stage *s)
{
    for (int t = 0; t < OST_WORLD_TOOLS_MAX; t++)
        ost_tool_free(s->tools[t]);
    ost_bone_free(s->bone);
}

static void step(stage *s, const ost_tick *tick)
{
    ost_error err = {0};
    if (tick->tool == s->count)
        assert_ok(ost_world_add_tool(s->world, "next", s->tools[s->count++], NULL, &err));
    assert_ok(ost_world_step(s->world, tick, NULL, &err));
}

static void move(stage *s, ost_backend *to)
{
    ost_error err = {0};
    stage before = *s;
    ost_tool *moved[OST_WORLD_TOOLS_MAX];
    assert_ok(ost_world_failover(s->world, to, &s->bone, moved, &err));
    /* ost_world_failover moves only the tools of the world. The other tools are copied here. */
    for (int t = 0; t < TOOLS; t++) {
        s->tools[t] = moved[t];
        if (t >= s->count) {
            ost_tool_volume volume;
            assert_null(moved[t]);
            assert_ok(ost_tool_download(before.tools[t], &volume, &err));
            assert_ok(ost_tool_upload(to, &volume, &s->tools[t], &err));
            ost_tool_volume_free(&volume);
        }
    }
    free_voxels(&before);
}

static void moved_world_equals_unmoved_world(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("moved");
    ost_backend *other;
    assert_ok(ost_backend_open("cpu:threads=2", &other, &err));
    for (int round = 0; round < test_rounds(24); round++) {
        plan p = make_plan(&rng);
        ost_tool_volume volumes[TOOLS];
        for (int t = 0; t < TOOLS; t++) {
            const ost_tool_geometry g = {
                .dims = {8, 6 + 4 * t, 9}, .voxel = 600 * UM, .corner = {-2400 * UM, -1800 * UM, 0}};
            ost_tool *tool = random_tool(other, &rng, g);
            assert_ok(ost_tool_download(tool, &volumes[t], &err));
            ost_tool_free(tool);
        }
        const int32_t keep = (int32_t)rng_range(&rng, 1, 25);
        const int at = (int)rng_range(&rng, 0, TICKS), again = (int)rng_range(&rng, 0, TICKS);
        stage plain = make_stage(&p, *state, 0, volumes), moving = make_stage(&p, *state, keep, volumes);
        for (int i = 0; i <= TICKS; i++) {
            if (i == at)
                move(&moving, other);
            if (i == again)
                move(&moving, *state);
            if (i < TICKS) {
                step(&plain, &p.ticks[i]);
                step(&moving, &p.ticks[i]);
            }
        }
        ost_world_totals a, b;
        ost_world_totals_get(plain.world, &a);
        ost_world_totals_get(moving.world, &b);
        assert_memory_equal(&a, &b, sizeof a);
        int16_t *va = content(plain.bone, &p.g), *vb = content(moving.bone, &p.g);
        assert_same_voxels(vb, va, &p.g);
        free(va);
        free(vb);
        for (int t = 0; t < TOOLS; t++)
            ost_tool_volume_free(&volumes[t]);
        ost_world_free(plain.world);
        ost_world_free(moving.world);
        free_voxels(&plain);
        free_voxels(&moving);
        free(p.voxels);
    }
    ost_backend_close(other);
}

static void invalid_failover_is_refused(void **state)
{
    ost_error err = {0};
    test_rng rng = {3};
    plan p = make_plan(&rng);
    ost_world *world;
    ost_bone *bone = bone_of(*state, &p.g, 16, p.voxels), *other = bone;
    ost_tool *tools[OST_WORLD_TOOLS_MAX];
    assert_int_equal(ost_world_create(bone, &(ost_world_options){.saved_ticks = -1}, &world, &err), OST_ERR_USAGE);
    assert_int_equal(
        ost_world_create(bone, &(ost_world_options){.saved_ticks = OST_WORLD_SAVED_TICKS_MAX + 1}, &world, &err),
        OST_ERR_USAGE);
    assert_ok(ost_world_create(bone, NULL, &world, &err));
    assert_int_equal(ost_world_failover(world, *state, &other, tools, &err), OST_ERR_USAGE);
    assert_null(other);
    assert_non_null(strstr(err.text, "saves no ticks"));
    ost_world_free(world);
    ost_bone_free(bone);
    free(p.voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moved_world_equals_unmoved_world),
        cmocka_unit_test(invalid_failover_is_refused),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
