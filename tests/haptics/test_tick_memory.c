/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tick allocates nothing: the loop, the operation, the step of the world and
 * the recorder, with a tool in contact that comes to chunk after chunk.
 *
 * malloc and its kin are ours here and count while a tick runs; that needs
 * glibc and no sanitizer, elsewhere the test is skipped.
 * Covers: REQ-SERVO
 */
#include "ref/scene.h"

#include <errno.h>

#include <osteon/operation.h>

#include "io/io_scratch.h"

#if defined __GLIBC__ && !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
#define COUNTING 1
#else
#define COUNTING 0
#endif
#if defined __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#undef COUNTING
#define COUNTING 0
#endif
#endif

static _Thread_local volatile bool watching; /* compilers know malloc, and that theirs does not look at it */
static _Thread_local volatile uint64_t calls;

#if COUNTING
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size)
{
    calls += watching;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    calls += watching;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    calls += watching;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    calls += watching;
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    calls += watching;
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : ENOMEM;
}
#endif

static bool watched_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    watching = true;
    return ost_operation_tick(operation, sample, wrench);
}

static void watched_done(void *operation, uint64_t number, uint32_t exec_ns)
{
    ost_operation_done(operation, number, exec_ns);
    watching = false;
}

static void a_tick_allocates_nothing(void **state)
{
    if (!COUNTING || strcmp(ost_backend_name(*state), "ref") == 0)
        skip();
    skip_without_samples(*state);
    ost_error err = {0};
    char *folder = scratch_folder(), name[4200];
    snprintf(name, sizeof name, "%s/m.session", folder);
    test_rng rng = {1};
    const ost_geometry g = cubic_geometry(80, 80, 80, 500 * UM, (ost_pm3){0, 0, 0});
    int16_t *voxels = random_densities(&rng, &g, 6);
    ost_bone *bone = bone_of(*state, &g, 32, voxels);
    free(voxels);
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{40, 40, 20}, 500 * UM, {-10000 * UM, -10000 * UM, 0}}, OST_TOOL_CUTTING);
    ost_world *world;
    assert_ok(ost_world_create(bone, NULL, &world, &err));
    assert_ok(ost_world_add_tool(world, "tool", tool, NULL, &err));
    /* Into the bone, across the borders of its chunks, turning a little. */
    ost_path path;
    assert_ok(ost_path_init(&path, 400, &err));
    for (size_t i = 0; i < path.count; i++)
        path.ticks[i] = (ost_tick){.pose = {.t = {(int64_t)(10000 + 50 * i) * UM, 20000 * UM, 15000 * UM}, .qw = OST_Q30_ONE, .qz = (int32_t)i * 20000}};
    ost_session_header *header;
    ost_recorder *recorder;
    ost_haptic *device;
    ost_operation *operation;
    static ost_servo_report report;
    assert_ok(ost_session_header_create(&header, &err));
    assert_ok(ost_recorder_open(name, header, NULL, &recorder, &err));
    assert_ok(ost_haptic_open("sim", &(ost_haptic_setup){.path = &path}, &device, &err));
    ost_force *force;
    assert_ok(ost_force_create(bone, NULL, &force, &err));
    assert_ok(ost_force_add_tool(force, tool, &err));
    assert_ok(ost_operation_create(world, &(ost_operation_options){.recorder = recorder, .force = force}, &operation, &err));
    calls = 0;
    assert_ok(ost_servo_run(device, &(ost_servo_options){.ticks = 400, .no_clock = true, .no_realtime = true}, watched_tick, watched_done, operation,
                            &report, &err));
    const uint64_t counted = calls;
    ost_operation_report done;
    ost_operation_report_get(operation, &done);
    assert_int_equal(done.steps, 400);
    ost_world_totals totals;
    ost_world_totals_get(world, &totals);
    assert_true(totals.removed_voxels > 10000 && done.touching_ticks > 300);
    assert_int_equal(counted, 0);
    /* And the counter counts. */
    watching = true;
    void *volatile some = calloc(1, 100);
    watching = false;
    free(some);
    assert_int_equal(calls, counted + 1);
    ost_operation_free(operation);
    ost_force_free(force);
    ost_haptic_close(device);
    assert_ok(ost_recorder_close(recorder, NULL, &err));
    ost_session_header_free(header);
    ost_path_free(&path);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_bone_free(bone);
    scratch_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_tick_allocates_nothing)};
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
