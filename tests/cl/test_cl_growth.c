/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that memory does not grow over many removal events. The shim counts OpenCL objects of
 * each kind, and the resident size of the process is measured.
 *
 * The test runs 4,000 events, or 100,000 with OST_TEST_LONG=1. During the first tenth, objects
 * are created once or grow to their final size. After that:
 *   - every event releases every object that it creates
 *   - the size of the process changes by at most 4 MiB; in the long test, this limit
 *     detects a leak of 47 bytes per event
 * The bone is filled again, by an upload, when half of it has been removed. These uploads also
 * create and release buffers. The final state must equal the reference's.
 *
 * The file tests/lsan.supp suppresses the reports of memory that a driver retains. OpenCL objects
 * that osteon does not release are therefore detected only by the counts of the shim.
 * Covers: REQ-CL-GROWTH
 */
#include "cl/on_device.h"
#include "cl/shim.h"
#include "ref/scene.h"

static ost_backend *open_shimmed(void)
{
    ost_error err = {0};
    const char *options = strchr(device_spec(), ':') ? strchr(device_spec(), ':') + 1 : "";
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&shim, options, &backend, &err));
    backend->ops = &ost_backend_cl;
    return backend;
}

/* Compares each kind separately, because a surplus of one kind could hide a deficit of another. */
static void assert_all_released(void)
{
    for (int kind = 0; kind < SHIM_OBJECTS; kind++) {
        const shim_count count = shim_objects((enum shim_object)kind);
        printf("# %s: %ld created, %ld released\n", shim_object_names[kind], count.created, count.released);
        if (count.created != count.released)
            fail_msg("%s: %ld objects were created, but %ld were released", shim_object_names[kind], count.created,
                     count.released);
    }
}

/* Returns the resident size of the process in KiB, or -1 if the system does not report it. */
static long resident_kib(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    long size, resident;
    if (!file)
        return -1;
    const int got = fscanf(file, "%ld %ld", &size, &resident);
    fclose(file);
    return got == 2 ? resident * (sysconf(_SC_PAGESIZE) / 1024) : -1;
}

/* Returns true if resident_kib measures only osteon and its driver, not a sanitizer or valgrind. */
static bool size_is_meaningful(void)
{
#if defined __SANITIZE_ADDRESS__
    return false; /* A sanitizer retains freed memory, so the size is not meaningful. */
#else
    return !getenv("OST_UNDER_VALGRIND") && resident_kib() > 0;
#endif
}

static void close_releases_every_object(void **state)
{
    (void)state;
    const long before = shim_alive();
    for (int again = 0; again < 5; again++) {
        ost_backend *backend = open_shimmed();
        assert_true(shim_alive() > before);
        ost_backend_close(backend);
        assert_int_equal(shim_alive(), before);
    }
    assert_all_released();
    const enum shim_object needed[] = {SHIM_CONTEXT, SHIM_QUEUE, SHIM_PROGRAM, SHIM_KERNEL, SHIM_BUFFER};
    for (size_t k = 0; k < sizeof needed / sizeof needed[0]; k++)
        assert_true(shim_objects(needed[k]).created >= 5); /* This proves that the shim counts this kind of object. */
}

typedef struct scene {
    ost_geometry g;
    int16_t *voxels;
    ost_backend *backend[2]; /* backend[0] is the reference, and backend[1] is the device */
    ost_bone *bone[2];
    ost_tool *tool[2];
    ost_removal_report report[2];
    scene_event *event;
} scene;

static void make_scene(scene *s, test_rng *rng)
{
    ost_error err = {0};
    *s = (scene){.g = cubic_geometry(60, 50, 40, 500 * UM, (ost_pm3){0, 0, 0})};
    const ost_tool_geometry tg = {.dims = {9, 9, 9}, .voxel = 500 * UM, .corner = {-2250 * UM, -2250 * UM, -2250 * UM}};
    s->voxels = random_densities(rng, &s->g, 7);
    s->event = malloc(sizeof *s->event);
    assert_non_null(s->event);
    assert_ok(ost_backend_open("ref", &s->backend[0], &err));
    s->backend[1] = open_shimmed();
    for (int b = 0; b < 2; b++) {
        s->bone[b] = bone_of(s->backend[b], &s->g, 16, s->voxels);
        s->tool[b] = solid_tool(s->backend[b], tg, OST_TOOL_CUTTING);
    }
}

static void free_scene(scene *s)
{
    for (int b = 0; b < 2; b++) {
        ost_removal_report_free(&s->report[b]);
        ost_tool_free(s->tool[b]);
        ost_bone_free(s->bone[b]);
        ost_backend_close(s->backend[b]);
    }
    free(s->event);
    free(s->voxels);
}

static void many_events_do_not_grow_memory(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("growth");
    const char *lengthy = getenv("OST_TEST_LONG");
    const int events = lengthy && strcmp(lengthy, "1") == 0 ? 100000 : getenv("OST_UNDER_VALGRIND") ? 200 : 4000;
    const ost_pm3 lo = {0, 0, 0}, hi = {30000 * UM, 25000 * UM, 20000 * UM};
    scene s;
    make_scene(&s, &rng);
    ost_bone_info full, now;
    assert_ok(ost_bone_info_get(s.bone[1], &full, &err));
    long objects = 0, size = 0, removed = 0, filled = 0;
    for (int i = 0; i < events; i++) {
        if (i == events / 10) {
            objects = shim_alive();
            size = resident_kib();
        }
        ost_pose poses[3];
        const int count = (int)rng_range(&rng, 1, 3);
        for (int k = 0; k < count; k++)
            poses[k] = random_pose(&rng, lo, hi);
        const ost_removal_event *event = event_of(s.event, &s.g, s.tool[1], poses, count);
        for (int k = 0; k < count; k++) /* A corner of the tool is 4.5 * sqrt(3) < 8 voxels from the tool's centre. */
            for (int a = 0; a < 3; a++) {
                const int32_t at = (int32_t)((a == 0   ? poses[k].t.x
                                              : a == 1 ? poses[k].t.y
                                                       : poses[k].t.z) /
                                             (500 * UM));
                s.event->boxes[k].lo[a] = at - 9;
                s.event->boxes[k].hi[a] = at + 10;
            }
        for (int b = 0; b < 2; b++)
            assert_ok(i % 16 == 7 ? ost_bone_collide(s.bone[b], s.tool[b], event, &s.report[b], &err)
                                  : ost_bone_remove(s.bone[b], s.tool[b], event, &s.report[b], &err));
        assert_int_equal(s.report[0].total_voxels, s.report[1].total_voxels);
        removed += (long)s.report[1].total_voxels;
        assert_ok(ost_bone_info_get(s.bone[1], &now, &err));
        if (now.active_voxels < full.active_voxels / 2) {
            for (int b = 0; b < 2; b++)
                assert_ok(ost_bone_upload(s.bone[b], 0, s.g.dims.z, s.voxels, &err));
            filled++;
        }
    }
    const ost_digest expected = digest_of(s.bone[0]), got = digest_of(s.bone[1]);
    assert_memory_equal(&got, &expected, sizeof got);
    const long grown = resident_kib() - size;
    printf("# %d events, %ld voxels removed, bone filled again %ld times; resident %ld KiB, growth %ld KiB\n", events,
           removed, filled, size, grown);
    assert_true(filled > 0 || events < 4000);
    assert_int_equal(shim_alive(), objects);
    if (size_is_meaningful() && grown > 4096)
        fail_msg("the resident size grew by %ld KiB; at most 4096 KiB are allowed", grown);
    free_scene(&s);
    assert_all_released();
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(close_releases_every_object),
        cmocka_unit_test(many_events_do_not_grow_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
