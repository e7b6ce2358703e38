/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a small session twice for each of its OpenCL calls. In the first run, this call fails. In the second
 * run, this call fails, and the device is lost from then on. In each run, the following must hold:
 *
 *   - the status is not OST_OK, and the message names the device, unless the backend can overcome
 *     the failure of this call
 *   - there is no crash, and every OpenCL object is released
 *   - a bone whose change failed is unchanged, or every later call reports that the
 *     bone is lost; a bone is never partly changed
 *   - the reference continues from the last completed tick to the same final grid
 * Covers: AR-REM-1
 */
#include "cl/on_device.h"
#include "cl/shim.h"
#include "mesh/mesh_make.h"
#include "ref/scene.h"

#include <time.h>

enum { EVENTS = 3, CALLS_MAX = 2000 };

/* Inputs of a session, and the results expected from it, computed by the reference. */
typedef struct session {
    ost_geometry g;
    int16_t *voxels;
    ost_snapped_mesh mesh;
    ost_sample samples[50];
    ost_pose poses[EVENTS][4];
    int16_t *after[EVENTS + 1]; /* after[n] contains the voxels of the bone after n events */
    ost_backend *ref;
    ost_tool *ref_tool;
} session;

static void make_session(session *s)
{
    ost_error err = {0};
    test_rng rng = {7};
    *s = (session){.g = cubic_geometry(40, 36, 34, 500 * UM, (ost_pm3){0, 0, 0})};
    s->voxels = random_densities(&rng, &s->g, 7);
    const ost_dims dims = {16, 15, 14};
    s->mesh = make_snapped(dims, 8, 12);
    make_box(&s->mesh, (const int64_t[3]){MAKE_ONE, MAKE_ONE, MAKE_ONE},
             (const int64_t[3]){14 * MAKE_ONE, 13 * MAKE_ONE, 12 * MAKE_ONE});
    for (int i = 0; i < 50; i++)
        s->samples[i] = (ost_sample){
            .x = i % 10 * 500 * UM, .y = i / 10 * 500 * UM, .density = 200 + i, .line = (uint32_t)i};
    for (int e = 0; e < EVENTS; e++)
        for (int k = 0; k < 4; k++)
            s->poses[e][k] = random_pose(&rng, (ost_pm3){2000 * UM, 2000 * UM, 2000 * UM},
                                         (ost_pm3){12000 * UM, 12000 * UM, 12000 * UM});
    assert_ok(ost_backend_open("ref", &s->ref, &err));
    assert_ok(ost_voxelize(s->ref, &s->mesh, NULL, OST_FILL_WINDING, NULL, &s->ref_tool, &err));
    ost_bone *bone = bone_of(s->ref, &s->g, 16, s->voxels);
    ost_removal_report report = {0};
    s->after[0] = content(bone, &s->g);
    for (int e = 0; e < EVENTS; e++) {
        remove_at(bone, &s->g, s->ref_tool, s->poses[e], 4, &report);
        assert_true(report.total_voxels > 0);
        s->after[e + 1] = content(bone, &s->g);
    }
    ost_removal_report_free(&report);
    ost_bone_free(bone);
}

static void free_session(session *s)
{
    ost_tool_free(s->ref_tool);
    ost_backend_close(s->ref);
    for (int e = 0; e <= EVENTS; e++)
        free(s->after[e]);
    ost_snapped_mesh_free(&s->mesh);
    free(s->voxels);
}

/* Checks that the bone either has the voxels after `done` events, or is reported as lost. Also checks that the
   reference reaches the expected final grid if it continues from the last completed tick. */
static void check_failover(const session *s, const ost_bone *bone, int done)
{
    const size_t bytes = voxel_count(&s->g) * sizeof(int16_t);
    ost_error err = {0};
    int16_t *now = malloc(bytes);
    assert_non_null(now);
    shim_fail(SHIM_clFinish, 0, false); /* This disables failures, so that the device works again. */
    ost_status status = ost_bone_download(bone, 0, s->g.dims.z, now, &err);
    if (status == OST_OK) {
        assert_memory_equal(now, s->after[done], bytes);
    } else {
        assert_int_equal(status, OST_ERR_UNAVAILABLE);
        assert_non_null(strstr(err.text, "is lost"));
    }
    free(now);
    ost_removal_report report = {0};
    ost_bone *other = bone_of(s->ref, &s->g, 32, s->after[done]);
    for (int e = done; e < EVENTS; e++)
        remove_at(other, &s->g, s->ref_tool, s->poses[e], 4, &report);
    int16_t *end = content(other, &s->g);
    assert_memory_equal(end, s->after[EVENTS], bytes);
    free(end);
    ost_removal_report_free(&report);
    ost_bone_free(other);
}

/* Checks a bone after a failed upload. Before the upload the bone contained slices 3 to 9. */
static void check_upload(const session *s, const ost_bone *bone)
{
    const size_t slice = 40 * 36, count = voxel_count(&s->g);
    ost_error err = {0};
    int16_t *now = malloc(count * sizeof *now);
    assert_non_null(now);
    shim_fail(SHIM_clFinish, 0, false);
    if (ost_bone_download(bone, 0, s->g.dims.z, now, &err) == OST_OK) {
        for (size_t v = 0; v < count; v++)
            assert_int_equal(now[v], v / slice >= 3 && v / slice < 10 ? s->after[0][v] : 0);
    } else {
        assert_non_null(strstr(err.text, "is lost"));
    }
    free(now);
}

/* Checks that a grid is lost after a failed upload, because its content is then undefined. */
static void check_grid(const session *s, const ost_grid *grid, int16_t *voxels)
{
    ost_error err = {0};
    shim_fail(SHIM_clFinish, 0, false);
    assert_int_equal(ost_grid_download(grid, 0, s->g.dims.z, voxels, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "is lost"));
}

/* Samples one voxel of each slice, and compares the densities with the expected densities after `done` events. */
static ost_status sample_column(const session *s, const ost_bone *bone, int done, ost_error *err)
{
    enum { SLICES = 100 };
    int32_t x[SLICES], y[SLICES], z[SLICES];
    int16_t got[SLICES];
    const int32_t *const at[3] = {x, y, z};
    assert_true(s->g.dims.z <= SLICES);
    for (int32_t i = 0; i < s->g.dims.z; i++) {
        x[i] = (i * 7 + done) % s->g.dims.x;
        y[i] = (i * 5 + done) % s->g.dims.y;
        z[i] = i;
    }
    ost_status status = ost_bone_sample(bone, (size_t)s->g.dims.z, at, got, err);
    for (int32_t i = 0; i < s->g.dims.z && status == OST_OK; i++)
        assert_int_equal(got[i], s->after[done][x[i] + s->g.dims.x * (y[i] + s->g.dims.y * z[i])]);
    return status;
}

static ost_status run_events(const session *s, ost_bone *bone, const ost_tool *tool, ost_error *err)
{
    scene_event *e = malloc(sizeof *e);
    ost_removal_report report = {0};
    assert_non_null(e);
    ost_status status = OST_OK;
    int done = 0;
    for (; done < EVENTS && status == OST_OK; done += status == OST_OK) {
        const ost_removal_event *event = event_of(e, &s->g, tool, s->poses[done], 4);
        status = sample_column(s, bone, done, err);
        if (status == OST_OK)
            status = ost_bone_collide(bone, tool, event, &report, err);
        if (status == OST_OK)
            status = ost_bone_remove(bone, tool, event, &report, err);
    }
    if (status == OST_OK)
        status = sample_column(s, bone, done, err);
    if (status != OST_OK)
        check_failover(s, bone, done);
    ost_removal_report_free(&report);
    free(e);
    return status;
}

/* Runs all stages once. Returns at the first failure. */
static ost_status run_session(const session *s, ost_error *err)
{
    const ost_geometry flat = {.dims = {10, 5, 1}, .spacing = {500 * UM, 500 * UM, 500 * UM}};
    const char *options = strchr(device_spec(), ':') ? strchr(device_spec(), ':') + 1 : "";
    ost_backend *backend = NULL;
    ost_grid *rect = NULL, *cubic = NULL, *complete = NULL;
    ost_bone *first = NULL, *bone = NULL;
    ost_tool *tool = NULL, *copy = NULL;
    ost_tool_volume volume = {.voxels = NULL};
    ost_scatter_report scatter = {0};
    ost_digest digest;
    int16_t *voxels = malloc(voxel_count(&s->g) * sizeof *voxels);
    assert_non_null(voxels);
    ost_status status = ost_cl_open_with(&shim, options, &backend, err);
    if (status == OST_OK) {
        backend->ops = &ost_backend_cl;
        status = ost_grid_create(backend, &flat, &rect, err);
    }
    if (status == OST_OK)
        status = ost_ct_to_rect(rect, s->samples, 50, 1, OST_DUPLICATES_ERROR, &scatter, err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(rect, 400 * UM, OST_RESAMPLE_LINEAR, &cubic, err);
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, 16, 120, &first, err);
    if (status == OST_OK)
        status = ost_grid_create(backend, &s->g, &complete, err);
    if (status == OST_OK) {
        status = ost_grid_upload(complete, 0, s->g.dims.z, s->voxels, err);
        if (status != OST_OK)
            check_grid(s, complete, voxels);
    }
    if (status == OST_OK)
        status = ost_grid_download(complete, 0, s->g.dims.z, voxels, err);
    if (status == OST_OK)
        status = ost_bone_create(backend, &s->g, 16, 120, &bone, err);
    if (status == OST_OK)
        status = ost_bone_upload(bone, 3, 7, s->voxels + 3 * 40 * 36, err);
    if (status == OST_OK) {
        status = ost_bone_upload(bone, 0, s->g.dims.z, s->voxels, err);
        if (status != OST_OK)
            check_upload(s, bone);
    }
    if (status == OST_OK)
        status = ost_voxelize(backend, &s->mesh, NULL, OST_FILL_WINDING, NULL, &tool, err);
    if (status == OST_OK)
        status = ost_tool_download(tool, &volume, err);
    if (status == OST_OK)
        status = ost_tool_upload(backend, &volume, &copy, err);
    if (status == OST_OK)
        status = run_events(s, bone, copy, err);
    if (status == OST_OK)
        status = ost_bone_digest(bone, NULL, &digest, err);
    if (status == OST_OK)
        status = ost_bone_download(bone, 0, s->g.dims.z, voxels, err);
    if (status == OST_OK)
        assert_memory_equal(voxels, s->after[EVENTS], voxel_count(&s->g) * sizeof *voxels);
    if (status == OST_OK)
        status = ost_backend_finish(backend, err);
    ost_tool_volume_free(&volume);
    ost_tool_free(copy);
    ost_tool_free(tool);
    ost_bone_free(bone);
    ost_bone_free(first);
    ost_grid_free(complete);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    ost_backend_close(backend);
    free(voxels);
    assert_int_equal(shim_alive(), 0);
    return status;
}

/* Returns the number n such that every n-th call is tested. If the sessions for all calls take at most a minute on the
   device, n is 1. On rusticl they take longer, because rusticl compiles the kernels again in each session. With
   OST_TEST_LONG=1, n is always 1. */
static int stride_of(const session *s)
{
    enum { CALLS = 450, SECONDS = 60 };
    struct timespec begin, end;
    ost_error err = {0};
    const char *lengthy = getenv("OST_TEST_LONG");
    shim_fail(SHIM_clFinish, 0, false);
    assert_ok(run_session(s, &err)); /* This session fills the kernel cache. */
    clock_gettime(CLOCK_MONOTONIC, &begin);
    assert_ok(run_session(s, &err));
    clock_gettime(CLOCK_MONOTONIC, &end);
    const double took = (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    const int stride = lengthy && strcmp(lengthy, "1") == 0 ? 1 : 1 + (int)(took * CALLS / SECONDS);
    if (stride > 1)
        printf("# a session takes %.1f s on this device: only every call number 1 + %d n fails\n", took, stride);
    return stride;
}

/* Returns true if the session may succeed although this call fails. After a failed query, the backend chooses
   another device or ignores the cache. When a backend is closed, a failure of the final wait has no effect. */
static bool failure_may_be_overcome(enum shim_call call)
{
    return call == SHIM_clGetPlatformIDs || call == SHIM_clGetDeviceIDs || call == SHIM_clGetDeviceInfo ||
           call == SHIM_clCreateProgramWithBinary || call == SHIM_clBuildProgram || call == SHIM_clFinish;
}

static void fail_every_call(bool lost)
{
    session s;
    make_session(&s);
    const int stride = stride_of(&s);
    for (int call = 0; call < SHIM_COUNT; call++) {
        int refused = 0;
        if (lost && !shim_goes_to_queue((enum shim_call)call))
            continue;
        for (int n = 1; n < CALLS_MAX; n += stride) {
            ost_error err = {0};
            shim_fail((enum shim_call)call, n, lost);
            ost_status status = run_session(&s, &err);
            const bool reached = shim_failed() || status != OST_OK;
            if (!reached)
                break;
            refused++;
            if (status == OST_OK) {
                if (!failure_may_be_overcome((enum shim_call)call))
                    fail_msg("call %d of %s failed, but no error was reported", n, shim_names[call]);
                continue;
            }
            if (!err.text[0] || strchr(err.text, '\n'))
                fail_msg("call %d of %s failed: the error '%s' is not one line", n, shim_names[call], err.text);
            if (!failure_may_be_overcome((enum shim_call)call) && !strstr(err.text, "OpenCL device '"))
                fail_msg("call %d of %s failed: the error '%s' does not name the device", n, shim_names[call],
                         err.text);
        }
        printf("# %s: %d calls failed%s\n", shim_names[call], refused, lost ? ", each with a loss of the device" : "");
    }
    shim_fail(SHIM_clFinish, 0, false);
    free_session(&s);
}

static void each_call_fails_once(void **state)
{
    (void)state;
    fail_every_call(false);
}

static void device_is_lost_at_each_call(void **state)
{
    (void)state;
    fail_every_call(true);
}

/* The cells of a tool and the buffers of a bone are created once and reused. If the launch that fills these objects
   fails and the failure is reported only later, the objects must be created again. */
static void failures_that_are_reported_late(void **state)
{
    (void)state;
    session s;
    ost_error err = {0};
    ost_backend *backend;
    ost_tool_volume volume = {0};
    ost_tool *tool;
    ost_removal_report report = {0};
    scene_event *event = malloc(sizeof *event);
    assert_non_null(event);
    make_session(&s);
    assert_ok(
        ost_cl_open_with(&shim, strchr(device_spec(), ':') ? strchr(device_spec(), ':') + 1 : "", &backend, &err));
    backend->ops = &ost_backend_cl;
    assert_ok(ost_tool_download(s.ref_tool, &volume, &err));
    assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
    for (int n = 1; n <= 6; n++) {
        ost_bone *first = bone_of(backend, &s.g, 16, s.voxels), *second = bone_of(backend, &s.g, 32, s.voxels);
        const ost_removal_event *made = event_of(event, &s.g, tool, s.poses[0], 4);
        shim_fail_late(SHIM_clEnqueueNDRangeKernel, n);
        if (ost_bone_remove(first, tool, made, &report, &err) == OST_OK)
            assert_false(shim_failed());
        else
            check_failover(&s, first, 0);
        shim_fail(SHIM_clFinish, 0, false);
        remove_at(second, &s.g, tool, s.poses[0], 4, &report);
        int16_t *now = content(second, &s.g);
        assert_memory_equal(now, s.after[1], voxel_count(&s.g) * sizeof *now);
        free(now);
        ost_bone_free(second);
        ost_bone_free(first);
        ost_tool_free(tool);
        assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
    }
    ost_removal_report_free(&report);
    ost_tool_free(tool);
    ost_tool_volume_free(&volume);
    ost_backend_close(backend);
    free_session(&s);
    free(event);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_call_fails_once),
        cmocka_unit_test(device_is_lost_at_each_call),
        cmocka_unit_test(failures_that_are_reported_late),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
