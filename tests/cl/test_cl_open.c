/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the opening of a device. The tests cover options, refused devices, a build that fails, and
 * the cache. A device is refused because of a property that it reports or a result that it
 * computes. The cache may be damaged, owned by others, invalid or missing.
 */
#include "cl/on_device.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cl/cache.h"
#include "cl/cl.h"
#include "cl/embedded.h"
#include "cl/kernels/shared.h"
#include "ref/scene.h"

/* ----------------------------------------------- options of the backend */

static void options(void **state)
{
    (void)state;
    ost_cl_options o;
    ost_error err = {0};
    assert_ok(ost_cl_options_read("", &o, &err));
    assert_true(!o.platform[0] && !o.device[0] && o.workgroup == 0 && o.kernels == OST_CL_SET_AUTO && o.staging == 0);
    assert_ok(ost_cl_options_read("kernels=gpu,staging=1024", &o, &err));
    assert_true(o.kernels == OST_CL_SET_GPU && o.staging == 1024);
    assert_ok(ost_cl_options_read("kernels=cpu,order=7", &o, &err));
    assert_int_equal(o.order, 7);
    assert_true(o.kernels == OST_CL_SET_CPU);
    assert_ok(ost_cl_options_read("device=1,platform=Portable Computing,workgroup=64", &o, &err));
    assert_string_equal(o.platform, "Portable Computing");
    assert_string_equal(o.device, "1");
    assert_int_equal(o.workgroup, 64);
    static const char *const wrong[] =
        {"platform",           "platform=",    "device=",         "isa=avx2", "workgroup=0",  "workgroup=x",
         "workgroup=99999999", "threads=2",    "platform=0,,x=1", "=",        "workgroup=-1", "kernels",
         "kernels=",           "kernels=both", "staging=1023",    "staging=", "order=0",      "order=x",
         "staging=9999999999"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (ost_cl_options_read(wrong[i], &o, &err) != OST_ERR_USAGE)
            fail_msg("the options '%s' were accepted", wrong[i]);

    ost_cl_device d = {
        .platform_index = 1, .device_index = 2, .platform_name = "Portable Computing Language", .name = "pthread-Xeon"};
    d.id = (cl_device_id)&d;
    static const struct {
        const char *text;
        bool fits;
    } words[] = {
        {"", true},
        {"platform=1", true},
        {"platform=0", false},
        {"platform=portable", true},
        {"platform=LANGUAGE", true},
        {"platform=rusticl", false},
        {"device=2", true},
        {"device=1", false},
        {"device=xeon", true},
        {"platform=1,device=xeon", true},
        {"platform=0,device=xeon", false},
        {"device=pthread-Xeon!", false},
    };
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        assert_ok(ost_cl_options_read(words[i].text, &o, &err));
        if (ost_cl_options_match(&o, &d) != words[i].fits)
            fail_msg("the options '%s' %s the device", words[i].text, words[i].fits ? "do not match" : "match");
    }
}

static const char *own_options(void)
{
    const char *colon = strchr(device_spec(), ':');
    return colon ? colon + 1 : "";
}

static ost_status try_open(const ost_cl_api *cl, const char *text, ost_error *err)
{
    ost_backend *backend;
    *err = (ost_error){0};
    ost_status status = ost_cl_open_with(cl, text, &backend, err);
    if (status == OST_OK) {
        backend->ops = &ost_backend_cl;
        ost_backend_close(backend);
    } else {
        assert_null(backend);
    }
    return status;
}

static void no_such_device(void **state)
{
    (void)state;
    ost_error err;
    assert_int_equal(try_open(&ost_cl_loader, "platform=nobody's", &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "nobody's"));
    assert_int_equal(try_open(&ost_cl_loader, "device=4096", &err), OST_ERR_UNAVAILABLE);
    char huge[128];
    snprintf(huge, sizeof huge, "%s%sworkgroup=65536", own_options(), own_options()[0] ? "," : "");
    assert_int_equal(try_open(&ost_cl_loader, huge, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "at most"));
}

/* ------------------------------- devices that return wrong values or errors */

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

/* Opens two backends with different kernel sets on one device at the same time. Each backend must contain only the
   kernels of its own set. */
static void both_kernel_sets_at_once(void **state)
{
    (void)state;
    static const enum ost_cl_kernel own[2] = {OST_CL_KERNEL_ost_remove_blocks, OST_CL_KERNEL_ost_remove};
    ost_backend *backend[2] = {NULL, NULL};
    for (int i = 0; i < 2; i++) {
        ost_error err = {0};
        char text[256];
        snprintf(text, sizeof text, "%s%skernels=%s", own_options(), own_options()[0] ? "," : "", i ? "gpu" : "cpu");
        const ost_status status = ost_cl_open_with(&ost_cl_loader, text, &backend[i], &err);
        if (i == 0 && status == OST_ERR_UNAVAILABLE && strstr(err.text, "too early for kernels=cpu"))
            continue;
        assert_ok(status);
        backend[i]->ops = &ost_backend_cl;
        const cl_backend *b = (const cl_backend *)backend[i];
        assert_int_equal(b->cpu_set, i == 0);
        assert_non_null(b->kernel[own[i]]);
        assert_null(b->kernel[own[1 - i]]);
        assert_int_equal(b->launched[own[i]], 0);
        assert_true(b->launched[OST_CL_KERNEL_ost_fingerprint] > 0);
    }
    for (int i = 0; i < 2; i++)
        ost_backend_close(backend[i]);
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

/* ---------------------------------------------------------------- cache */

/* Returns the path of the only file in the cache's folder. */
static void entry_path(const char *cache, char *path, size_t size)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%s/osteon", cache);
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    path[0] = 0;
    for (const struct dirent *e; (e = readdir(dir));)
        if (e->d_name[0] != '.') {
            assert_int_equal(path[0], 0);
            assert_true((size_t)snprintf(path, size, "%s/%s", folder, e->d_name) < size);
        }
    closedir(dir);
    assert_true(path[0] != 0);
}

static unsigned char *read_all(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size = (size_t)ftell(f);
    rewind(f);
    unsigned char *bytes = malloc(*size);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, f), *size);
    fclose(f);
    return bytes;
}

static void write_all(const char *path, const unsigned char *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

/* Opens the first suitable device. Returns true if its program came from the cache. */
static bool opened_from_cache(void)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&ost_cl_loader, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const bool from_cache = ((cl_backend *)backend)->from_cache;
    ost_backend_close(backend);
    return from_cache;
}

/* Returns true if the platform of the first suitable device has this name. */
static bool on_platform(const char *name)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&ost_cl_loader, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const bool is = strcmp(((cl_backend *)backend)->device.platform_name, name) == 0;
    ost_backend_close(backend);
    return is;
}

/* Makes a new cache folder for the backends that the test opens next, and stores the path of the old folder in
   `before`. PoCL's cache stays in the old folder. */
static void begin_cache(char *folder, char *before, size_t size)
{
    snprintf(before, size, "%s", getenv("XDG_CACHE_HOME"));
    assert_non_null(mkdtemp(folder));
    setenv("XDG_CACHE_HOME", folder, 1);
    setenv("POCL_CACHE_DIR", before, 0);
}

static void end_cache(const char *folder, const char *before)
{
    char command[100];
    setenv("XDG_CACHE_HOME", before, 1);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
}

/*
 * PoCL compiles all kernels of a program when the program's binary is requested, which is slow. Therefore, on PoCL,
 * the first program that a process builds from source is not stored. The second program is stored. This test must be
 * the first test that opens a device.
 */
static void first_program_is_cached_unless_pocl(void **state)
{
    (void)state;
    char before[4096], folder[] = "/tmp/osteon-cache-XXXXXX", osteon[64];
    begin_cache(folder, before, sizeof before);
    snprintf(osteon, sizeof osteon, "%s/osteon", folder);
    assert_false(opened_from_cache());
    const bool stored = access(osteon, F_OK) == 0;
    assert_int_equal(opened_from_cache(), stored);
    assert_true(opened_from_cache());
    assert_int_equal(access(osteon, F_OK), 0);
    assert_int_equal(stored, !on_platform("Portable Computing Language"));
    end_cache(folder, before);
}

static void damaged_cache_entries_are_replaced(void **state)
{
    (void)state;
    char before[4096], folder[] = "/tmp/osteon-cache-XXXXXX", path[5000];
    begin_cache(folder, before, sizeof before);

    assert_false(opened_from_cache());
    assert_true(opened_from_cache());
    entry_path(folder, path, sizeof path);
    size_t size;
    unsigned char *good = read_all(path, &size);
    unsigned char *bad = malloc(size + 1);
    assert_non_null(bad);
    assert_true(size > 80);

    /*
     * The lengths to which the cache entry is truncated, and the positions at which a byte is changed. The
     * positions are in the header, the key, the checksum and the binary.
     */
    const size_t cuts[] = {0, 1, 7, 79, 80, size / 2, size - 1},
                 flips[] = {0, 8, 15, 16, 47, 48, 79, 80, size / 2, size - 1};
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
        write_all(path, good, cuts[i]);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }
    for (size_t i = 0; i < sizeof flips / sizeof flips[0]; i++) {
        memcpy(bad, good, size);
        bad[flips[i]] ^= 0x10;
        write_all(path, bad, size);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }
    memcpy(bad, good, size);
    bad[size] = 0;
    write_all(path, bad, size + 1); /* The entry is one byte longer than its length field states. */
    assert_false(opened_from_cache());

    /* This entry contains an invalid binary, but its magic, length, key and checksum are right. Only an attacker
       would write such an entry. The binary is passed to the driver. rusticl (Mesa 22.3) aborts the process in its
       program.rs instead of returning an error. */
    ost_digest checksum;
    if (on_platform("rusticl"))
        printf("# an invalid binary is not tested, because rusticl aborts the process\n");
    else {
        const char rubbish[] = "not a driver's binary";
        const uint64_t length = sizeof rubbish;
        assert_int_equal(ost_digest_bytes(rubbish, sizeof rubbish, &checksum, NULL), OST_OK);
        memcpy(bad, good, 80);
        memcpy(bad + 8, &length, 8);
        memcpy(bad + 48, &checksum, 32);
        memcpy(bad + 80, rubbish, sizeof rubbish);
        write_all(path, bad, 80 + sizeof rubbish);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }

    /* The path of the cache is first that of a file, then that of a folder that cannot be created. */
    setenv("XDG_CACHE_HOME", path, 1);
    assert_false(opened_from_cache());
    setenv("XDG_CACHE_HOME", "/proc/nothing", 1);
    assert_false(opened_from_cache());

    free(bad);
    free(good);
    end_cache(folder, before);
}

/* A cache that other users may have written must be neither read nor written. */
static void cache_of_other_users_is_not_used(void **state)
{
    (void)state;
    char before[4096], cache[] = "/tmp/osteon-cache-XXXXXX", folder[64], elsewhere[64], path[5000], moved[5100];
    struct stat info;
    begin_cache(cache, before, sizeof before);
    snprintf(folder, sizeof folder, "%s/osteon", cache);
    snprintf(elsewhere, sizeof elsewhere, "%s/elsewhere", cache);

    assert_false(opened_from_cache());
    assert_int_equal(stat(folder, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0700);
    entry_path(cache, path, sizeof path);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    assert_true(opened_from_cache());

    /* A cache folder to which its group or others may write must be neither used nor changed. */
    const mode_t open_modes[] = {0770, 0702};
    for (size_t i = 0; i < sizeof open_modes / sizeof open_modes[0]; i++) {
        assert_int_equal(chmod(folder, open_modes[i]), 0);
        assert_false(opened_from_cache());
        assert_false(opened_from_cache());
    }
    assert_int_equal(chmod(folder, 0700), 0);
    assert_true(opened_from_cache());

    /* A cache entry that other users may write to is replaced by a new entry that they may not write to. */
    assert_int_equal(chmod(path, 0620), 0);
    assert_false(opened_from_cache());
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    assert_true(opened_from_cache());

    /* Symbolic links to a valid entry and to a valid folder must not be followed. */
    snprintf(moved, sizeof moved, "%s/moved", cache);
    assert_int_equal(rename(path, moved), 0);
    assert_int_equal(symlink(moved, path), 0);
    assert_false(opened_from_cache());
    assert_int_equal(lstat(path, &info), 0);
    assert_true(S_ISREG(info.st_mode)); /* The link was replaced, not followed. */
    assert_true(opened_from_cache());
    assert_int_equal(rename(folder, elsewhere), 0);
    assert_int_equal(symlink(elsewhere, folder), 0);
    assert_false(opened_from_cache());
    assert_false(opened_from_cache());
    assert_int_equal(unlink(folder), 0);
    assert_int_equal(rename(elsewhere, folder), 0);
    assert_true(opened_from_cache());

    /* An entry or folder of another user is not used. Only root can create one for this test. */
    if (geteuid() == 0 && chown(path, 65534, 65534) == 0) {
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
        assert_int_equal(chown(folder, 65534, 65534), 0);
        assert_false(opened_from_cache());
        assert_false(opened_from_cache());
    } else
        printf("# a folder of another user is not tested, because only root can create it\n");

    end_cache(cache, before);
}

static ost_digest key_now(void)
{
    const ost_cl_device device = {.platform_name = "P", .platform_version = "OpenCL 1.2", .name = "D", .driver = "1"};
    const char *const sources[] = {"a", "b"};
    ost_cl_cache cache;
    ost_error err = {0};
    assert_ok(ost_cl_key(&device, sources, 2, "", &cache, &err));
    return cache.key;
}

/*
 * The key depends on the environment variables that are settings of a driver. It does not depend on cache
 * folders or on variables of other programs.
 */
static void cache_key_depends_on_driver_settings(void **state)
{
    (void)state;
    static const char *const matter[] = {"POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_METHOD", "RUSTICL_FEATURES",
                                         "GALLIVM_PERF", "CL_CONFIG_X"};
    static const char *const do_not[] = {"POCL_CACHE_DIR", "MESA_SHADER_CACHE_DIR", "OST_ANYTHING", "XPOCL_X"};
    const ost_digest before = key_now();
    for (size_t i = 0; i < sizeof matter / sizeof matter[0]; i++) {
        char *kept = getenv(matter[i]) ? strdup(getenv(matter[i])) : NULL;
        setenv(matter[i], "sse2-or-so", 1);
        const ost_digest one = key_now();
        setenv(matter[i], "another", 1);
        const ost_digest other = key_now();
        if (kept)
            setenv(matter[i], kept, 1);
        else
            unsetenv(matter[i]);
        free(kept);
        if (ost_digest_equal(&one, &before) || ost_digest_equal(&one, &other))
            fail_msg("the cache key does not depend on %s", matter[i]);
    }
    for (size_t i = 0; i < sizeof do_not / sizeof do_not[0]; i++) {
        char *kept = getenv(do_not[i]) ? strdup(getenv(do_not[i])) : NULL;
        setenv(do_not[i], "/somewhere/else", 1);
        const ost_digest now = key_now();
        if (kept)
            setenv(do_not[i], kept, 1);
        else
            unsetenv(do_not[i]);
        free(kept);
        if (!ost_digest_equal(&now, &before))
            fail_msg("the cache key depends on %s", do_not[i]);
    }
    /* The key does not depend on the order in which the variables were set. */
    setenv("POCL_B", "1", 1);
    setenv("POCL_A", "2", 1);
    const ost_digest first = key_now();
    unsetenv("POCL_B");
    setenv("POCL_B", "1", 1);
    const ost_digest second = key_now();
    unsetenv("POCL_A");
    unsetenv("POCL_B");
    const ost_digest after = key_now();
    assert_true(ost_digest_equal(&first, &second) && !ost_digest_equal(&first, &before) &&
                ost_digest_equal(&after, &before));
}

/* -------------------------------------------------------------- devices */

typedef struct seen {
    int devices, available;
} seen;

static void check_device(const ost_device_info *device, void *user)
{
    seen *s = user;
    s->devices++;
    s->available += device->available;
    assert_int_equal(strncmp(device->spec, "cl:platform=", 12), 0);
    assert_true(device->platform[0] != 0);
    assert_true(device->available ? device->notes[0] != 0 && !device->reason[0] : device->reason[0] != 0);
}

static void devices_are_listed(void **state)
{
    (void)state;
    ost_error err = {0};
    seen s = {0, 0};
    for (int i = 0; i < ost_backend_count(); i++)
        assert_ok(ost_backend_devices(i, check_device, &s, &err));
    assert_true(s.available > 0);
    assert_int_equal(ost_backend_devices(-1, check_device, &s, &err), OST_ERR_USAGE);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_program_is_cached_unless_pocl),
        cmocka_unit_test(options),
        cmocka_unit_test(no_such_device),
        cmocka_unit_test(refused_for_a_reported_property),
        cmocka_unit_test(refused_without_int64),
        cmocka_unit_test(no_platform),
        cmocka_unit_test(no_device),
        cmocka_unit_test(refused_for_a_wrong_result),
        cmocka_unit_test(devices_that_end_loops_early),
        cmocka_unit_test(both_kernel_sets_at_once),
        cmocka_unit_test(too_many_poses),
        cmocka_unit_test(failing_build_is_reported),
        cmocka_unit_test(damaged_cache_entries_are_replaced),
        cmocka_unit_test(cache_of_other_users_is_not_used),
        cmocka_unit_test(cache_key_depends_on_driver_settings),
        cmocka_unit_test(devices_are_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
