/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares each tick of a removal with the reference, for every instruction set of this machine and several
 * thread counts: after each tick the report and every voxel must be equal. These tests examine the state of
 * the bone and the backend after each event. They include slow and fast motion, stops, reversals, rotation
 * in place, sweeps, collisions in between, alternating tools and bones, and bones that are uploaded again.
 * Other tests move the tool's grid so that it only just overlaps a block of 16^3 voxels, or only just misses it.
 * Covers: AR-MAP-4, AR-MAP-5, AR-REM-1..6, AR-LAW-1, AR-LAW-2
 */
#include "cpu/team.h"

#include "sim/box.h"

enum { BONES = 2, TOOLS = 3 };

/* The bones and tools of a sequence, created on one backend. */
typedef struct setup {
    ost_bone *bone[BONES];
    ost_tool *tool[TOOLS];
} setup;

typedef struct inputs {
    ost_geometry geometry[BONES];
    int16_t *voxels[BONES];
    int chunk_size[BONES];
    ost_tool_volume volume[TOOLS];
} inputs;

static inputs make_inputs(test_rng *rng)
{
    const ost_pm s = 470 * UM;
    inputs p;
    for (int b = 0; b < BONES; b++) {
        p.geometry[b] = cubic_geometry((int32_t)rng_range(rng, 20, 45), (int32_t)rng_range(rng, 20, 45),
                                       (int32_t)rng_range(rng, 20, 45), s,
                                       (ost_pm3){rng_range(rng, -20, 20) * s, 123456789, 0});
        p.voxels[b] = random_densities(rng, &p.geometry[b], (int)rng_range(rng, 5, 8));
        p.chunk_size[b] = 16 << rng_range(rng, 0, 2);
    }
    /*
     * Sizes of tool voxels in thousandths of a bone voxel, two for each tool. The first tool has
     * windows of step 3, the second tool has windows of step 1 or no windows, and the third tool
     * has windows of step 2 (see src/cpu/remove/shape.h).
     */
    static const int64_t share[TOOLS][2] = {{1064, 1064}, {750, 400}, {900, 900}};
    for (int t = 0; t < TOOLS; t++)
        p.volume[t] = random_form(rng, s * share[t][rng_range(rng, 0, 1)] / 1000, 40);
    return p;
}

static setup open_setup(ost_backend *backend, const inputs *p)
{
    ost_error err = {0};
    setup b;
    for (int i = 0; i < BONES; i++)
        b.bone[i] = bone_of(backend, &p->geometry[i], p->chunk_size[i], p->voxels[i]);
    for (int i = 0; i < TOOLS; i++)
        assert_ok(ost_tool_upload(backend, &p->volume[i], &b.tool[i], &err));
    return b;
}

static void close_setup(setup *b)
{
    for (int i = 0; i < BONES; i++)
        ost_bone_free(b->bone[i]);
    for (int i = 0; i < TOOLS; i++)
        ost_tool_free(b->tool[i]);
}

/* Returns a random pose in a bone or near it. */
static ost_pose random_pose_near_bone(test_rng *rng, const ost_geometry *g)
{
    const ost_pm s = g->spacing.x;
    ost_pose pose = random_pose(rng, (ost_pm3){-5 * s, -5 * s, -5 * s},
                                (ost_pm3){(g->dims.x + 5) * s, (g->dims.y + 5) * s, (g->dims.z + 5) * s});
    pose.t.x += g->origin.x;
    pose.t.y += g->origin.y;
    pose.t.z += g->origin.z;
    return pose;
}

/* A tool's motion during some ticks: displacement and change of the quaternion per tick. */
typedef struct motion {
    ost_pm3 way;
    int32_t turn[3];
} motion;

static motion some_motion(test_rng *rng)
{
    const int64_t way = (int64_t[]){0, 5, 20, 100, 300, 4000}[rng_range(rng, 0, 5)] * UM;
    const int64_t turn = (int64_t[]){0, 0, 50000, 2000000, 20000000}[rng_range(rng, 0, 4)];
    motion m = {.way = {rng_range(rng, -way, way), rng_range(rng, -way, way), rng_range(rng, -way, way)}};
    for (int i = 0; i < 3; i++)
        m.turn[i] = (int32_t)rng_range(rng, -turn, turn);
    return m;
}

/* Returns the pose one tick later. The rotation stops if the length of the quaternion would differ too much from 1. */
static ost_pose moved(const ost_pose *from, const motion *m)
{
    ost_pose to = *from;
    to.t.x += m->way.x;
    to.t.y += m->way.y;
    to.t.z += m->way.z;
    ost_pose turned = to;
    turned.qx += m->turn[0];
    turned.qy += m->turn[1];
    turned.qz += m->turn[2];
    return ost_pose_check(&turned, NULL) == OST_OK ? turned : to;
}

/* Actions of one tick. */
typedef struct tick {
    int bone, tool, poses;
    ost_pose pose[4];
    bool tight, collide, upload;
    int32_t z0, slices;
} tick;

static void do_tick(const inputs *p, const setup *b, const tick *k, ost_removal_report *report)
{
    ost_error err = {0};
    const ost_geometry *g = &p->geometry[k->bone];
    scene_event e;
    if (k->upload)
        assert_ok(ost_bone_upload(b->bone[k->bone], k->z0, k->slices,
                                  p->voxels[k->bone] + (size_t)k->z0 * (size_t)g->dims.x * (size_t)g->dims.y, &err));
    event_of(&e, g, b->tool[k->tool], k->pose, k->poses);
    for (int i = 0; i < k->poses && k->tight; i++) {
        const ost_box box = ost_box_of_tool(&p->volume[k->tool].geometry);
        e.boxes[i] = ost_box_voxels(g, &box, &k->pose[i]);
    }
    if (k->collide)
        assert_ok(ost_bone_collide(b->bone[k->bone], b->tool[k->tool], &e.event, report, &err));
    else
        assert_ok(ost_bone_remove(b->bone[k->bone], b->tool[k->tool], &e.event, report, &err));
}

static void one_sequence(const team *t, test_rng *rng, int ticks, int turn)
{
    inputs p = make_inputs(rng);
    setup expected = open_setup(t->ref, &p), own[BACKENDS_MAX];
    for (int i = 0; i < t->count; i++)
        if (has_turn(i, turn))
            own[i] = open_setup(t->cpu[i], &p);
    tick k = {0};
    ost_pose at = random_pose_near_bone(rng, &p.geometry[0]);
    motion m = some_motion(rng);
    ost_removal_report report = {0}, found = {0};
    for (int n = 0; n < ticks; n++) {
        k.upload = false;
        switch (rng_range(rng, 0, 39)) {
        case 0:
            k.bone = (int)rng_range(rng, 0, BONES - 1);
            at = random_pose_near_bone(rng, &p.geometry[k.bone]);
            break;
        case 1:
            k.upload = true;
            k.z0 = (int32_t)rng_range(rng, 0, p.geometry[k.bone].dims.z - 1);
            k.slices = (int32_t)rng_range(rng, 1, p.geometry[k.bone].dims.z - k.z0);
            break;
        case 2:
            at = random_pose_near_bone(rng, &p.geometry[k.bone]);
            break;
        case 3:
            m.way = (ost_pm3){-m.way.x, -m.way.y, -m.way.z};
            break;
        case 4:
        case 5:
        case 6:
        case 7:
            m = some_motion(rng);
            break;
        default:
            break;
        }
        if (rng_range(rng, 0, 9) == 0)
            k.tool = (int)rng_range(rng, 0, TOOLS - 1);
        k.collide = rng_range(rng, 0, 5) == 0;
        k.tight = rng_range(rng, 0, 3) > 0;
        k.poses = rng_range(rng, 0, 7) == 0 ? (int)rng_range(rng, 2, 4) : 1;
        for (int i = 0; i < k.poses; i++)
            k.pose[i] = at = moved(&at, &m);
        if (llabs(at.t.x) > 60000 * UM || llabs(at.t.y) > 60000 * UM || llabs(at.t.z) > 60000 * UM)
            at = random_pose_near_bone(rng, &p.geometry[k.bone]);
        do_tick(&p, &expected, &k, &report);
        int16_t *left = content(expected.bone[k.bone], &p.geometry[k.bone]);
        for (int i = 0; i < t->count; i++) {
            if (!has_turn(i, turn))
                continue;
            do_tick(&p, &own[i], &k, &found);
            assert_same_report(&found, &report);
            int16_t *is = content(own[i].bone[k.bone], &p.geometry[k.bone]);
            assert_same_voxels(is, left, &p.geometry[k.bone]);
            free(is);
        }
        free(left);
    }
    ost_removal_report_free(&report);
    ost_removal_report_free(&found);
    for (int i = 0; i < t->count; i++)
        if (has_turn(i, turn))
            close_setup(&own[i]);
    close_setup(&expected);
    for (int i = 0; i < BONES; i++)
        free(p.voxels[i]);
    for (int i = 0; i < TOOLS; i++)
        ost_tool_volume_free(&p.volume[i]);
}

static void random_sequences(void **state)
{
    test_rng rng = rng_seeded("random sequences");
    for (int round = 0; round < 10; round++)
        one_sequence(*state, &rng, 120, round);
}

/*
 * Tests a solid tool that fills its grid. The tool's voxels are as large as the bone's. The tool is rotated
 * by quarter turns or not at all. It moves along one axis from one side of a block to the opposite side. It
 * starts and ends outside the block, and each step is one voxel plus or minus one picometre.
 */
static void block_limits_of_the_tool_grid(void **state)
{
    const team *t = *state;
    const ost_pm s = 470 * UM;
    const ost_geometry g = cubic_geometry(48, 48, 48, s, (ost_pm3){0});
    test_rng rng = rng_seeded("borders of blocks");
    int16_t *voxels = random_densities(&rng, &g, 8);
    const int32_t half = 759250125;
    const ost_pose turns[] = {{{0}, OST_Q30_ONE, 0, 0, 0},
                              {{0}, half, half, 0, 0},
                              {{0}, half, 0, -half, 0},
                              {{0}, 0, 0, 0, OST_Q30_ONE},
                              {{0}, OST_Q30_ONE / 2, OST_Q30_ONE / 2, OST_Q30_ONE / 2, OST_Q30_ONE / 2}};
    for (int turn = 0; turn < 5; turn++)
        for (int a = 0; a < 3; a++)
            for (int32_t at = -4; at <= 21; at++) {
                ost_pose pose = turns[turn];
                const ost_pm nudge = rng_range(&rng, -1, 1);
                const ost_pm where[3] = {a == 0 ? at * s + s / 2 + nudge : 24 * s,
                                         a == 1 ? at * s + s / 2 + nudge : 24 * s,
                                         a == 2 ? at * s + s / 2 + nudge : 24 * s};
                pose.t = (ost_pm3){where[0], where[1], where[2]};
                ost_tool_geometry of = {{3, 3, 3}, s, {-s, -s, -s}};
                ost_bone *expected = bone_of(t->ref, &g, 32, voxels);
                ost_tool *tool = solid_tool(t->ref, of, OST_TOOL_CUTTING);
                ost_removal_report report = {0}, found = {0};
                remove_at(expected, &g, tool, &pose, 1, &report);
                ost_tool_free(tool);
                const ost_digest digest = digest_of(expected);
                for (int i = 0; i < t->count; i += THREADS) {
                    ost_bone *bone = bone_of(t->cpu[i], &g, 32, voxels);
                    tool = solid_tool(t->cpu[i], of, OST_TOOL_CUTTING);
                    remove_at(bone, &g, tool, &pose, 1, &found);
                    assert_same_report(&found, &report);
                    const ost_digest own = digest_of(bone);
                    assert_memory_equal(&own, &digest, sizeof digest);
                    ost_tool_free(tool);
                    ost_bone_free(bone);
                }
                ost_removal_report_free(&report);
                ost_removal_report_free(&found);
                ost_bone_free(expected);
            }
    free(voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_sequences),
        cmocka_unit_test(block_limits_of_the_tool_grid),
    };
    return cmocka_run_group_tests(tests, open_team, close_team);
}
