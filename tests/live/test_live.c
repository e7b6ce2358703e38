/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the live state of a changing bone. A viewer reads the state at random speed. In the end, the
 * surface of the viewer must be bit-identical to a surface made from the bone itself. A state must be
 * complete and never older than the previous state. An interrupted call of ost_live_take must not lose
 * changes.
 * Covers: REQ-LIVE
 */
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include <osteon/live.h>
#include <osteon/operation.h>

#include "ref/scene.h"
#include "render/points/surface.h"

#define MM OST_PM_PER_MM

static ost_status into_surface(void *user, const int32_t at[3], const uint32_t *words, ost_error *err)
{
    ost_surface *surface = user;
    return ost_surface_set_chunk(surface, at, surface->geometry.dims.x, words, err);
}

static int compare_positions(const void *a, const void *b)
{
    const ost_surface_block *x = *(ost_surface_block *const *)a, *y = *(ost_surface_block *const *)b;
    return memcmp(x->at, y->at, sizeof x->at);
}

/* Sorts the blocks by position. */
static void sort_blocks(ost_surface *s)
{
    qsort(s->slot, (size_t)s->used, sizeof *s->slot, compare_positions);
}

/* Compares two surfaces. A block that has become empty may be present in one of them only. */
static void assert_same_surface(ost_surface *a, ost_surface *b)
{
    int32_t i = 0, j = 0;
    assert_int_equal(a->points, b->points);
    sort_blocks(a);
    sort_blocks(b);
    for (;; i++, j++) {
        while (i < a->used && a->slot[i]->count == 0)
            i++;
        while (j < b->used && b->slot[j]->count == 0)
            j++;
        if (i == a->used || j == b->used)
            break;
        const ost_surface_block *x = a->slot[i], *y = b->slot[j];
        assert_memory_equal(x->at, y->at, sizeof x->at);
        assert_memory_equal(x->occupancy, y->occupancy, sizeof x->occupancy);
        assert_int_equal(x->count, y->count);
        assert_memory_equal(x->points, y->points, x->count * sizeof *x->points);
        assert_memory_equal(x->shades, y->shades, x->count * sizeof *x->shades);
    }
    assert_int_equal(i, a->used);
    assert_int_equal(j, b->used);
}

static void surface_of_bone(const ost_bone *bone, const ost_geometry *g, ost_surface *out)
{
    ost_error err = {0};
    int16_t *voxels = content(bone, g);
    const ost_volume volume = {.geometry = *g, .voxels = voxels};
    assert_ok(ost_surface_init(out, g, &err));
    assert_ok(ost_surface_set_volume(out, &volume, 120, &err));
    assert_ok(ost_surface_update(out, &err));
    free(voxels);
}

/* ----------------------------------------------------------- occupancy */

static void occupancy_equals_active_voxels(void **state)
{
    test_rng rng = rng_seeded("occupancy");
    const ost_geometry g = cubic_geometry(70, 45, 67, MM, (ost_pm3){0, 0, 0});
    int16_t *voxels = random_densities(&rng, &g, 4);
    for (int n = 16; n <= 64; n *= 2) {
        ost_error err = {0};
        ost_bone_info info;
        ost_bone *bone = bone_of(*state, &g, n, voxels);
        assert_ok(ost_bone_info_get(bone, &info, &err));
        const size_t size = (size_t)(n * n * n / 32);
        uint32_t *words = malloc((size_t)info.chunks * size * sizeof *words);
        int32_t *chunks = malloc((size_t)info.chunks * sizeof *chunks);
        assert_non_null(words);
        assert_non_null(chunks);
        for (int32_t c = 0; c < info.chunks; c++)
            chunks[c] = (int32_t)info.chunks - 1 - c;
        assert_ok(ost_bone_occupancy(bone, (size_t)info.chunks, chunks, words, &err));
        for (int32_t i = 0; i < info.chunks; i++)
            for (int v = 0; v < n * n * n; v++) {
                const int32_t c = chunks[i], x = c % info.chunk_dims.x * n + v % n,
                              y = c / info.chunk_dims.x % info.chunk_dims.y * n + v / n % n;
                const int32_t z = c / info.chunk_dims.x / info.chunk_dims.y * n + v / n / n;
                const bool inside = x < g.dims.x && y < g.dims.y && z < g.dims.z;
                const bool active = inside && voxels[x + (size_t)g.dims.x * (size_t)(y + g.dims.y * z)] >= 120;
                if ((words[(size_t)i * size + (size_t)v / 32] >> (v % 32) & 1) != active)
                    fail_msg("chunks of %d voxels per side: voxel (%d, %d, %d) is %s in the occupancy", n, (int)x,
                             (int)y, (int)z, active ? "not active" : "active");
            }
        chunks[0] = (int32_t)info.chunks;
        assert_int_equal(ost_bone_occupancy(bone, 1, chunks, words, &err), OST_ERR_USAGE);
        free(words);
        free(chunks);
        ost_bone_free(bone);
    }
    free(voxels);
}

/* ------------------------------------------------------- tick and viewer */

typedef struct viewer_thread {
    ost_live_channel *live;
    ost_surface *surface;
    test_rng rng;
    _Atomic bool stop;
    ost_status status;
    ost_error err;
    uint64_t ticks, takes;
    bool torn;
} viewer_thread;

/* Returns the state with the number `tick`. All fields of the state are functions of this number. */
static ost_live_state state_of(uint64_t tick)
{
    ost_live_state s = {
        .ticks = tick, .t_ns = (int64_t)tick * 1000000, .removed_voxels = 7 * tick, .fault = (int32_t)(tick % 5)};
    s.pose = (ost_pose){.t = {(int64_t)tick, -(int64_t)tick, 3 * (int64_t)tick}, .qw = OST_Q30_ONE};
    for (int a = 0; a < 3; a++)
        s.force_n[a] = (double)tick * (a + 1);
    return s;
}

static void view(viewer_thread *l)
{
    ost_live_state s;
    if (ost_live_state_get(l->live, &s)) {
        const ost_live_state expected = state_of(s.ticks);
        l->torn = l->torn || s.ticks < l->ticks || s.t_ns != expected.t_ns ||
                  s.removed_voxels != expected.removed_voxels || s.fault != expected.fault ||
                  s.pose.t.z != expected.pose.t.z || s.force_n[2] != expected.force_n[2];
        l->ticks = s.ticks;
    }
    if (l->status == OST_OK)
        l->status = ost_live_take(l->live, into_surface, l->surface, &l->err);
    if (l->status == OST_OK && rng_range(&l->rng, 0, 3) == 0)
        l->status = ost_surface_update(l->surface, &l->err);
    l->takes++;
}

static void *view_until_stopped(void *user)
{
    viewer_thread *l = user;
    while (!atomic_load(&l->stop)) {
        view(l);
        const struct timespec nap = {.tv_nsec = rng_range(&l->rng, 0, 9) ? rng_range(&l->rng, 0, 50000)
                                                                         : rng_range(&l->rng, 0, 1000000)};
        nanosleep(&nap, NULL);
    }
    return NULL;
}

/* Each grid is as wide as its chunks, so that into_surface can derive the chunk size. */
static void viewer_surface_equals_bone(void **state)
{
    test_rng rng = rng_seeded("live");
    for (int n = 16; n <= 64; n *= 2) {
        ost_error err = {0};
        const ost_geometry g = cubic_geometry(n, 100, 70, MM, (ost_pm3){0, 0, 0});
        int16_t *voxels = random_densities(&rng, &g, 7);
        /* Some chunks are empty at the start. */
        for (size_t i = 0; i < voxel_count(&g) / 3; i++)
            voxels[i] = 0;
        ost_bone *bone = bone_of(*state, &g, n, voxels);
        ost_tool *tool = random_tool(*state, &rng, (ost_tool_geometry){{9, 12, 20}, MM, {-4 * MM, -6 * MM, 0}});
        ost_surface seen, expected;
        viewer_thread l = {.surface = &seen, .rng = {rng_next(&rng)}};
        ost_removal_report report = {0};
        assert_ok(ost_surface_init(&seen, &g, &err));
        assert_ok(ost_live_create(bone, &l.live, &err));
        assert_int_equal(ost_live_chunk_size(l.live), n);
        assert_true(ost_geometry_equal(ost_live_geometry(l.live), &g));
        pthread_t thread;
        assert_int_equal(pthread_create(&thread, NULL, view_until_stopped, &l), 0);
        /* The reference is slow, so it runs fewer rounds. The other backends are fast enough to overtake the viewer. */
        const int rounds = strcmp(test_backend, "ref") == 0 ? 60 : 400;
        for (int i = 1; i <= rounds; i++) {
            const ost_pose pose = random_pose(&rng, (ost_pm3){0, 0, 0}, (ost_pm3){n * MM, 100 * MM, 70 * MM});
            const ost_live_state shown = state_of((uint64_t)i);
            remove_at(bone, &g, tool, &pose, 1, &report);
            ost_live_changed(l.live, i % 7 ? &report : NULL);
            if (i % 7 == 0)
                ost_live_changed(l.live, &report);
            assert_ok(ost_live_publish(l.live, &shown, &err));
        }
        assert_ok(ost_live_flush(l.live, &err));
        atomic_store(&l.stop, true);
        pthread_join(thread, NULL);
        view(&l);
        assert_ok(ost_surface_update(&seen, &err));
        if (l.status != OST_OK)
            fail_msg("%s", l.err.text);
        assert_false(l.torn);
        assert_int_equal(l.ticks, rounds);
        surface_of_bone(bone, &g, &expected);
        assert_same_surface(&seen, &expected);
        print_message("# chunks of %d voxels per side: %llu calls of ost_live_take during %d removals, %llu surface "
                      "voxels\n",
                      n, (unsigned long long)l.takes, rounds, (unsigned long long)expected.points);
        ost_surface_free(&expected);
        ost_surface_free(&seen);
        ost_live_free(l.live);
        ost_removal_report_free(&report);
        ost_tool_free(tool);
        ost_bone_free(bone);
        free(voxels);
    }
}

/* ------------------------------------------------------- other properties */

typedef struct limited {
    int left;
    ost_surface *surface;
} limited;

static ost_status set_limited_chunks(void *user, const int32_t at[3], const uint32_t *words, ost_error *err)
{
    limited *l = user;
    if (l->left-- == 0)
        return ost_fail(err, OST_ERR_MEMORY, "the limit of chunks is reached");
    return ost_surface_set_chunk(l->surface, at, 32, words, err);
}

static void interrupted_take_loses_no_changes(void **state)
{
    test_rng rng = rng_seeded("ended take");
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(100, 90, 80, MM, (ost_pm3){0, 0, 0});
    int16_t *voxels = random_densities(&rng, &g, 5);
    ost_bone *bone = bone_of(*state, &g, 32, voxels);
    ost_live_channel *live;
    ost_surface seen, expected;
    assert_ok(ost_surface_init(&seen, &g, &err));
    assert_ok(ost_live_create(bone, &live, &err));
    ost_live_state none;
    assert_false(ost_live_state_get(live, &none));
    int ended = 0;
    limited l = {.left = 5, .surface = &seen};
    while (ost_live_take(live, set_limited_chunks, &l, &err) != OST_OK) {
        l.left = 5;
        ended++;
    }
    assert_int_equal(ended, (4 * 3 * 3 - 1) / 5);
    assert_ok(ost_surface_update(&seen, &err));
    surface_of_bone(bone, &g, &expected);
    assert_same_surface(&seen, &expected);
    ost_surface_free(&expected);
    ost_surface_free(&seen);
    ost_live_free(live);
    ost_bone_free(bone);
    free(voxels);
}

static void empty_bone_can_be_viewed(void **state)
{
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(40, 40, 40, MM, (ost_pm3){0, 0, 0});
    ost_bone *bone;
    ost_live_channel *live;
    ost_surface seen;
    assert_ok(ost_bone_create(*state, &g, 32, 120, &bone, &err));
    assert_ok(ost_live_create(bone, &live, &err));
    assert_ok(ost_surface_init(&seen, &g, &err));
    limited l = {.left = 0, .surface = &seen};
    assert_ok(ost_live_take(live, set_limited_chunks, &l, &err));
    assert_ok(ost_live_flush(live, &err));
    ost_surface_free(&seen);
    ost_live_free(live);
    ost_bone_free(bone);
    assert_int_equal(ost_live_create(NULL, &live, &err), OST_ERR_USAGE);
}

/* An operation must publish its own ticks. */
static void operation_publishes_its_ticks(void **state)
{
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(60, 60, 60, MM, (ost_pm3){0, 0, 0});
    test_rng rng = rng_seeded("operation");
    int16_t *voxels = random_densities(&rng, &g, 8);
    ost_bone *bone = bone_of(*state, &g, 32, voxels);
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{6, 6, 12}, MM, {-3 * MM, -3 * MM, 0}}, OST_TOOL_CUTTING);
    ost_world *world;
    ost_live_channel *live;
    ost_operation *operation;
    ost_haptic *device;
    ost_path path;
    ost_surface seen, expected;
    static ost_servo_report loop;
    assert_ok(ost_world_create(bone, NULL, &world, &err));
    assert_ok(ost_world_add_tool(world, "peg", tool, NULL, &err));
    assert_ok(ost_live_create(bone, &live, &err));
    assert_ok(ost_path_init(&path, 300, &err));
    for (size_t i = 0; i < path.count; i++)
        path.ticks[i] = (ost_tick){.t_ns = (int64_t)i * 1000000,
                                   .rpm = OST_RPM_ON,
                                   .pose = {.t = {30 * MM, 30 * MM, (55 - (int64_t)i / 6) * MM}, .qw = OST_Q30_ONE}};
    assert_ok(ost_haptic_open("script", &(ost_haptic_setup){.path = &path}, &device, &err));
    assert_ok(ost_operation_create(world, &(ost_operation_options){.live = live}, &operation, &err));
    const ost_servo_options options = {.no_clock = true, .no_realtime = true};
    assert_ok(ost_servo_run(device, &options, ost_operation_tick, ost_operation_done, operation, &loop, &err));
    ost_live_state last;
    ost_world_totals totals;
    assert_true(ost_live_state_get(live, &last));
    ost_world_totals_get(world, &totals);
    assert_int_equal(last.ticks, 300);
    assert_int_equal(last.removed_voxels, totals.removed_voxels);
    assert_true(totals.removed_voxels > 0);
    assert_int_equal(last.pose.t.z, path.ticks[299].pose.t.z);
    assert_ok(ost_live_flush(live, &err));
    assert_ok(ost_surface_init(&seen, &g, &err));
    limited l = {.left = -1, .surface = &seen};
    assert_ok(ost_live_take(live, set_limited_chunks, &l, &err));
    assert_ok(ost_surface_update(&seen, &err));
    surface_of_bone(bone, &g, &expected);
    assert_same_surface(&seen, &expected);
    ost_surface_free(&expected);
    ost_surface_free(&seen);
    ost_operation_free(operation);
    ost_haptic_close(device);
    ost_path_free(&path);
    ost_live_free(live);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_bone_free(bone);
    free(voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(occupancy_equals_active_voxels),
        cmocka_unit_test(viewer_surface_equals_bone),
        cmocka_unit_test(interrupted_take_loses_no_changes),
        cmocka_unit_test(empty_bone_can_be_viewed),
        cmocka_unit_test(operation_publishes_its_ticks),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
