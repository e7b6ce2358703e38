/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests errors of devices and drivers, which replaced OpenCL functions simulate. A device must be refused if it reports
 * an unsuitable property or computes a wrong result. A build that fails must be reported. A device that ends loops
 * early must be opened with the kernels that it can run, and must refuse events with too many poses.
 */
#include "cl/try_open.h"

#include "cl/embedded.h"
#include "ref/scene.h"

static cl_device_info requested;
static const void *answer;
static size_t answer_size;

/*
 * Returns the test's answer to the query of the property `requested`. Passes all other queries to the
 * device.
 */
static cl_int changed_info(cl_device_id device, cl_device_info what, size_t capacity, void *value, size_t *size)
{
    if (what != requested)
        return clGetDeviceInfo(device, what, capacity, value, size);
    if (size)
        *size = answer_size;
    if (value && capacity >= answer_size)
        memcpy(value, answer, answer_size);
    return CL_SUCCESS;
}

static void refused_with_info(cl_device_info what, const void *value, size_t size, const char *reason)
{
    ost_error err;
    ost_cl_api api = ost_cl_loader;
    char text[256];
    api.clGetDeviceInfo = changed_info;
    requested = what;
    answer = value;
    answer_size = size;
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    if (!strstr(err.text, reason))
        fail_msg("the error '%s' does not contain '%s'", err.text, reason);
    assert_false(ost_cl_available_with(&api, text, sizeof text));
    assert_true(text[0] != 0);
}

static void refused_for_a_reported_property(void **state)
{
    (void)state;
    const cl_bool no = CL_FALSE;
    refused_with_info(CL_DEVICE_AVAILABLE, &no, sizeof no, "not available");
    refused_with_info(CL_DEVICE_COMPILER_AVAILABLE, &no, sizeof no, "no compiler");
    refused_with_info(CL_DEVICE_ENDIAN_LITTLE, &no, sizeof no, "little-endian");
    refused_with_info(CL_DEVICE_VERSION, "OpenCL 1.1 old", 15, "OpenCL 1.2 is needed");
    refused_with_info(CL_DEVICE_OPENCL_C_VERSION, "OpenCL C 1.0", 13, "OpenCL 1.2 is needed");
    refused_with_info(CL_DEVICE_OPENCL_C_VERSION, "rubbish", 8, "OpenCL 1.2 is needed");
}

/* Reports an embedded profile. A device with this profile has 64-bit integers only if it reports cles_khr_int64. */
static cl_int embedded_info(cl_device_id device, cl_device_info what, size_t capacity, void *value, size_t *size)
{
    const char *text = what == CL_DEVICE_PROFILE ? "EMBEDDED_PROFILE" : what == CL_DEVICE_EXTENSIONS ? answer : NULL;
    if (!text)
        return clGetDeviceInfo(device, what, capacity, value, size);
    if (size)
        *size = strlen(text) + 1;
    if (value && capacity >= strlen(text) + 1)
        memcpy(value, text, strlen(text) + 1);
    return CL_SUCCESS;
}

static void refused_without_int64(void **state)
{
    (void)state;
    ost_error err;
    ost_cl_api api = ost_cl_loader;
    api.clGetDeviceInfo = embedded_info;
    answer = "cl_khr_byte_addressable_store cles_khr_int64_hints ";
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "64-bit integers"));
    answer = "cl_khr_fp64 cles_khr_int64";
    assert_ok(try_open(&api, own_options(), &err));
}

static cl_int no_platforms(cl_uint capacity, cl_platform_id *ids, cl_uint *count)
{
    (void)capacity;
    (void)ids;
    *count = 0;
    return -1001;
}

static void no_platform(void **state)
{
    (void)state;
    ost_error err;
    char reason[256];
    ost_cl_api api = ost_cl_loader;
    api.clGetPlatformIDs = no_platforms;
    assert_int_equal(try_open(&api, "", &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "OpenCL"));
    assert_false(ost_cl_available_with(&api, reason, sizeof reason));
    assert_true(strlen(reason) > 20);
}

static cl_int no_devices(cl_platform_id platform, cl_device_type type, cl_uint capacity, cl_device_id *ids,
                         cl_uint *count)
{
    (void)platform;
    (void)type;
    (void)capacity;
    (void)ids;
    if (count)
        *count = 0;
    return CL_DEVICE_NOT_FOUND;
}

static void check_no_device(const ost_device_info *device, void *user)
{
    ++*(int *)user;
    assert_false(device->available);
    assert_non_null(strstr(device->reason, "has no device"));
}

/* Tests a loader whose platforms have no devices. */
static void no_device(void **state)
{
    (void)state;
    int platforms = 0;
    ost_error err = {0};
    char reason[256];
    ost_cl_api api = ost_cl_loader;
    api.clGetDeviceIDs = no_devices;
    assert_int_equal(try_open(&api, "", &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no device"));
    assert_false(ost_cl_available_with(&api, reason, sizeof reason));
    assert_non_null(strstr(reason, "no device"));
    assert_ok(ost_cl_visit_with(&api, check_no_device, &platforms, &err));
    assert_true(platforms > 0);
}

static size_t flip_size, flip_at;

/* Simulates an error of the driver's compiler: flips one bit of one result. */
static cl_int flipping_read(cl_command_queue queue, cl_mem buffer, cl_bool wait, size_t offset, size_t size, void *to,
                            cl_uint count, const cl_event *after, cl_event *event)
{
    cl_int code = clEnqueueReadBuffer(queue, buffer, wait, offset, size, to, count, after, event);
    if (size >= flip_size)
        ((unsigned char *)to)[flip_at] ^= 4;
    return code;
}

static void refused_for_a_wrong_result(void **state)
{
    (void)state;
    ost_error err;
    ost_cl_api api = ost_cl_loader;
    api.clEnqueueReadBuffer = flipping_read;
    flip_size = 100000; /* Only the read of the fingerprint results has this size or more. */
    flip_at = (500 * OST_CL_FINGERPRINT + 6) * 8 + 1; /* a byte of word 6 of item 500 */
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "wrong integer result"));
    assert_non_null(strstr(err.text, "(long)int * 100"));
    flip_size = 1; /* Every read has this size or more. The first read returns the layout of structs. */
    flip_at = 12;  /* a byte of value 3 */
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "ost_cl_scatter.count"));
}

static uint32_t turns_given;

/*
 * Simulates a driver that ends loops early. Only the result of the loop test has 8 bytes, so no other read is changed.
 */
static cl_int read_of_short_loops(cl_command_queue queue, cl_mem buffer, cl_bool wait, size_t offset, size_t size,
                                  void *to, cl_uint count, const cl_event *after, cl_event *event)
{
    cl_int code = clEnqueueReadBuffer(queue, buffer, wait, offset, size, to, count, after, event);
    uint32_t turns[2] = {turns_given, 0};
    for (uint32_t n = 0; n < turns_given; n++)
        turns[1] = OST_CL_NEXT_TURN(turns[1]);
    if (size == sizeof turns && turns_given)
        memcpy(to, turns, sizeof turns);
    return code;
}

/*
 * A device that ends loops early is opened with the GPU kernel set if its loops run long enough for this
 * set. If they end earlier, the device is refused.
 */
static void devices_that_end_loops_early(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_cl_api api = ost_cl_loader;
    ost_backend *backend;
    api.clEnqueueReadBuffer = read_of_short_loops;
    turns_given = 65535;
    assert_ok(ost_cl_open_with(&api, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const cl_backend *b = (const cl_backend *)backend;
    assert_false(b->cpu_set);
    assert_int_equal(b->turns, 65535);
    assert_non_null(b->kernel[OST_CL_KERNEL_ost_remove]);
    assert_null(b->kernel[OST_CL_KERNEL_ost_remove_blocks]);
    ost_backend_close(backend);
    char named[256];
    snprintf(named, sizeof named, "%s%skernels=cpu", own_options(), own_options()[0] ? "," : "");
    /* A kernel set that the user chose is not replaced. */
    assert_int_equal(try_open(&api, named, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "too early for kernels=cpu"));
    turns_given = OST_CL_TURNS_LEAST - 1;
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "ends a loop after 61503 iterations"));
}

/* An event with more poses than a device with limited loops allows must be refused before anything changes. An event
   with the maximum number of poses must be performed. */
static void too_many_poses(void **state)
{
    (void)state;
    enum { TURNS = 65535, MOST = OST_CL_TURNS_POSES(TURNS), SIDE = 8 };
    ost_error err = {0};
    ost_cl_api api = ost_cl_loader;
    ost_backend *backend;
    api.clEnqueueReadBuffer = read_of_short_loops;
    turns_given = TURNS;
    assert_ok(ost_cl_open_with(&api, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    turns_given = 0; /* From here on, reads return the results of the device. */

    const ost_pm s = OST_PM_PER_MM / 2;
    const ost_geometry g = cubic_geometry(SIDE, SIDE, SIDE, s, (ost_pm3){0, 0, 0});
    int16_t voxels[SIDE * SIDE * SIDE];
    for (size_t i = 0; i < voxel_count(&g); i++)
        voxels[i] = 500;
    ost_bone *bone = bone_of(backend, &g, 16, voxels);
    ost_tool *tool = solid_tool(backend, (ost_tool_geometry){.dims = {2, 2, 2}, .voxel = s, .corner = {-s, -s, -s}},
                                OST_TOOL_CUTTING);
    const ost_pose pose = {.t = {4 * s, 4 * s, 4 * s}, .qw = OST_Q30_ONE};
    const ost_density_classes classes = ost_density_classes_default();
    ost_map *maps = calloc(MOST + 1, sizeof *maps);
    ost_voxel_box *boxes = calloc(MOST + 1, sizeof *boxes);
    ost_removal_report report = {0};
    assert_true(maps && boxes);
    for (int k = 0; k <= MOST; k++) {
        assert_ok(ost_map_make(&pose, &g, ost_tool_geometry_get(tool), &maps[k], &err));
        boxes[k] = (ost_voxel_box){.hi = {SIDE, SIDE, SIDE}};
    }
    ost_removal_event event = {.pose_count = MOST + 1, .maps = maps, .boxes = boxes, .classes = &classes};
    assert_int_equal(ost_bone_remove(bone, tool, &event, &report, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "ends a loop after 65535 iterations"));
    assert_non_null(strstr(err.text, "3619 poses"));
    int16_t *now = content(bone, &g);
    assert_memory_equal(now, voxels, sizeof voxels);
    free(now);
    event.pose_count = MOST;
    assert_ok(ost_bone_remove(bone, tool, &event, &report, &err));
    assert_int_equal(report.total_voxels, 8);
    for (int z = 3; z < 5; z++)
        for (int y = 3; y < 5; y++)
            for (int x = 3; x < 5; x++)
                voxels[x + SIDE * (y + SIDE * z)] = 0;
    now = content(bone, &g);
    assert_same_voxels(now, voxels, &g);
    free(now);
    ost_removal_report_free(&report);
    free(boxes);
    free(maps);
    ost_tool_free(tool);
    ost_bone_free(bone);
    ost_backend_close(backend);
}

static cl_program broken_source(cl_context context, cl_uint count, const char **texts, const size_t *lengths,
                                cl_int *code)
{
    const char *wrong = "\n#line 42 \"removal.cl\"\n__kernel void ost_remove(int x) { return nonsense; }\n";
    (void)count;
    (void)texts;
    (void)lengths;
    return clCreateProgramWithSource(context, 1, &wrong, NULL, code);
}

static void failing_build_is_reported(void **state)
{
    (void)state;
    ost_error err;
    ost_cl_api api = ost_cl_loader;
    char before[4096];
    snprintf(before, sizeof before, "%s", getenv("XDG_CACHE_HOME"));
    setenv("XDG_CACHE_HOME", "/dev/null/no-folder", 1); /* No driver can create this cache folder, even as root. */
    api.clCreateProgramWithSource = broken_source;
    assert_int_equal(try_open(&api, own_options(), &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "clBuildProgram"));
    assert_non_null(strstr(err.text, "nonsense"));
    assert_null(strchr(err.text, '\n'));
    setenv("XDG_CACHE_HOME", before, 1);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refused_for_a_reported_property),
        cmocka_unit_test(refused_without_int64),
        cmocka_unit_test(no_platform),
        cmocka_unit_test(no_device),
        cmocka_unit_test(refused_for_a_wrong_result),
        cmocka_unit_test(devices_that_end_loops_early),
        cmocka_unit_test(too_many_poses),
        cmocka_unit_test(failing_build_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
