/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sharing with OpenGL, on a platform that a shim makes report the extension: its
 * OpenGL buffer is an ordinary OpenCL buffer, and the calls are recorded.
 *
 *   - every access to the words is between acquire and release, and is finished
 *     before OpenGL may draw
 *   - the words in the buffer are the bone's occupancy, and the grids are those of
 *     the reference, as without sharing
 *   - a call that fails leaves the bone unchanged or lost
 *
 * This does not show whether a real platform can share.
 * Covers: REQ-CL-GL
 */
#include "cl/on_device.h"
#include "cl/share.h"
#include "cl/shim.h"
#include "ref/scene.h"

enum { GL_BUFFER = 77 };
static const ost_cl_gl a_context = {.kind = OST_CL_GL_EGL, .context = (void *)0x1230, .display = (void *)0x4560};

/* ------------------------------------------------- a platform that shares */

static cl_mem shared;     /* the buffer made from GL_BUFFER */
static char calls[4096];  /* A acquire, R release, F finish; on the shared buffer: K kernel, C copy, r read, w write */
static bool held, kernel_has_it[OST_CL_KERNEL_COUNT];
static cl_kernel kernels[OST_CL_KERNEL_COUNT];
static enum { NOTHING, CONTEXT, BUFFER, ACQUIRE, RELEASE } refused;

static void note(char what)
{
    const size_t length = strlen(calls);
    if (length + 1 < sizeof calls)
        calls[length] = what, calls[length + 1] = 0;
}

static void touches(char what)
{
    note(what);
    if (!held)
        fail_msg("the shared buffer is used when GL has it: %s", calls);
}

static cl_int info_gl(cl_device_id device, cl_device_info what, size_t capacity, void *value, size_t *size)
{
    static const char text[] = "cl_khr_gl_sharing_not cl_khr_fp64 cl_khr_gl_sharing";
    if (what != CL_DEVICE_EXTENSIONS)
        return shim.clGetDeviceInfo(device, what, capacity, value, size);
    if (size)
        *size = sizeof text;
    if (value && capacity >= sizeof text)
        memcpy(value, text, sizeof text);
    return CL_SUCCESS;
}

static cl_context context_gl(const cl_context_properties *p, cl_uint count, const cl_device_id *devices,
                             void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user, cl_int *code)
{
    assert_int_equal(p[0], CL_GL_CONTEXT_KHR);
    assert_int_equal(p[1], 0x1230);
    assert_int_equal(p[2], CL_EGL_DISPLAY_KHR);
    assert_int_equal(p[3], 0x4560);
    assert_int_equal(p[4], CL_CONTEXT_PLATFORM);
    if (refused == CONTEXT) {
        *code = CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
        return NULL;
    }
    return shim.clCreateContext(p + 4, count, devices, notify, user, code);
}

static cl_mem buffer_gl(cl_context context, cl_mem_flags flags, cl_GLuint name, int *code)
{
    assert_int_equal(name, GL_BUFFER);
    assert_int_equal(flags, CL_MEM_READ_WRITE);
    if (refused == BUFFER) {
        *code = CL_INVALID_GL_OBJECT;
        return NULL;
    }
    shared = shim.clCreateBuffer(context, flags, 1 << 20, NULL, code);
    return shared;
}

static cl_int acquire_gl(cl_command_queue queue, cl_uint count, const cl_mem *objects, cl_uint waits, const cl_event *list, cl_event *event)
{
    (void)queue, (void)waits, (void)list, (void)event;
    assert_true(count == 1 && objects[0] == shared && !held);
    note('A');
    if (refused == ACQUIRE)
        return CL_OUT_OF_RESOURCES;
    held = true;
    return CL_SUCCESS;
}

static cl_int release_gl(cl_command_queue queue, cl_uint count, const cl_mem *objects, cl_uint waits, const cl_event *list, cl_event *event)
{
    (void)queue, (void)waits, (void)list, (void)event;
    assert_true(count == 1 && objects[0] == shared && held);
    note('R');
    held = false;
    return refused == RELEASE ? CL_OUT_OF_RESOURCES : CL_SUCCESS;
}

static cl_int finish_gl(cl_command_queue queue)
{
    note('F');
    return shim.clFinish(queue);
}

/* Arguments persist in a kernel: it has the buffer if its last words argument was the buffer. */
static cl_int arg_gl(cl_kernel kernel, cl_uint index, size_t size, const void *value)
{
    for (int k = 0; k < OST_CL_KERNEL_COUNT && size == sizeof(cl_mem) && shared; k++)
        if (!kernels[k] || kernels[k] == kernel) {
            kernels[k] = kernel;
            kernel_has_it[k] = index == 0 ? false : kernel_has_it[k];
            if (memcmp(value, &shared, sizeof shared) == 0)
                kernel_has_it[k] = true;
            break;
        }
    return shim.clSetKernelArg(kernel, index, size, value);
}

static cl_int launch_gl(cl_command_queue queue, cl_kernel kernel, cl_uint dims, const size_t *offset, const size_t *global,
                        const size_t *local, cl_uint count, const cl_event *after, cl_event *event)
{
    for (int k = 0; k < OST_CL_KERNEL_COUNT; k++)
        if (kernels[k] == kernel && kernel_has_it[k])
            touches('K');
    return shim.clEnqueueNDRangeKernel(queue, kernel, dims, offset, global, local, count, after, event);
}

static cl_int copy_gl(cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset, size_t size, cl_uint count,
                      const cl_event *after, cl_event *event)
{
    if (shared && (from == shared || to == shared))
        touches('C');
    return shim.clEnqueueCopyBuffer(queue, from, to, from_offset, to_offset, size, count, after, event);
}

static cl_int read_gl(cl_command_queue queue, cl_mem buffer, cl_bool wait, size_t offset, size_t size, void *to, cl_uint count,
                      const cl_event *after, cl_event *event)
{
    if (shared && buffer == shared)
        touches('r');
    return shim.clEnqueueReadBuffer(queue, buffer, wait, offset, size, to, count, after, event);
}

static cl_int free_gl(cl_mem buffer)
{
    if (buffer == shared) {
        assert_false(held);
        shared = NULL;
        memset(kernel_has_it, 0, sizeof kernel_has_it);
    }
    return shim.clReleaseMemObject(buffer);
}

static ost_cl_api sharing_api(void)
{
    ost_cl_api api = shim;
    api.clGetDeviceInfo = info_gl;
    api.clCreateContext = context_gl;
    api.clCreateFromGLBuffer = buffer_gl;
    api.clEnqueueAcquireGLObjects = acquire_gl;
    api.clEnqueueReleaseGLObjects = release_gl;
    api.clFinish = finish_gl;
    api.clSetKernelArg = arg_gl;
    api.clEnqueueNDRangeKernel = launch_gl;
    api.clEnqueueCopyBuffer = copy_gl;
    api.clEnqueueReadBuffer = read_gl;
    api.clReleaseMemObject = free_gl;
    memset(kernels, 0, sizeof kernels);
    memset(kernel_has_it, 0, sizeof kernel_has_it);
    shared = NULL;
    held = false;
    refused = NOTHING;
    return api;
}

/* Asserts that the calls recorded since the last check have the form A work R F, with work of these kinds. */
static void assert_held(const char *work)
{
    const size_t length = strlen(calls);
    if (length < 4 || calls[0] != 'A' || strcmp(calls + length - 2, "RF") != 0 || strcspn(calls, "R") != length - 2 || !strpbrk(calls, work))
        fail_msg("calls were '%s'", calls);
    calls[0] = 0;
}

static const char *own_options(void)
{
    const char *colon = strchr(device_spec(), ':');
    return colon ? colon + 1 : "";
}

/* ----------------------------------------------------------------- tests */

static void properties(void **state)
{
    (void)state;
    cl_context_properties p[OST_CL_GL_PROPERTIES];
    const cl_platform_id platform = (cl_platform_id)0x789;
    ost_cl_gl_properties(NULL, platform, p);
    assert_true(p[0] == CL_CONTEXT_PLATFORM && p[1] == 0x789 && p[2] == 0);
    static const cl_context_properties displays[] = {CL_GLX_DISPLAY_KHR, CL_EGL_DISPLAY_KHR, CL_WGL_HDC_KHR};
    for (int kind = OST_CL_GL_GLX; kind <= OST_CL_GL_WGL; kind++) {
        ost_cl_gl_properties(&(ost_cl_gl){.kind = (ost_cl_gl_kind)kind, .context = (void *)1, .display = (void *)2}, platform, p);
        assert_true(p[0] == CL_GL_CONTEXT_KHR && p[1] == 1 && p[2] == displays[kind] && p[3] == 2);
        assert_true(p[4] == CL_CONTEXT_PLATFORM && p[5] == 0x789 && p[6] == 0);
    }
}

static cl_int info_without(cl_device_id device, cl_device_info what, size_t capacity, void *value, size_t *size)
{
    if (what == CL_DEVICE_EXTENSIONS && value)
        return capacity >= 16 ? memcpy(value, "cl_khr_gl_sharin", 16), CL_SUCCESS : CL_INVALID_VALUE;
    if (what == CL_DEVICE_EXTENSIONS && size)
        return *size = 16, CL_SUCCESS;
    return shim.clGetDeviceInfo(device, what, capacity, value, size);
}

static void not_possible(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    ost_cl_api api = sharing_api();
    api.clGetDeviceInfo = info_without;
    assert_int_equal(ost_cl_open_shared(&api, own_options(), &a_context, &backend, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "cl_khr_gl_sharing"));
    api = sharing_api();
    refused = CONTEXT;
    assert_int_equal(ost_cl_open_shared(&api, own_options(), &a_context, &backend, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "cannot share with this context"));
    assert_int_equal(shim_alive(), 0);
}

/* Compares every chunk's words, which OpenGL would draw, with its voxels. */
static void assert_words(const ost_bone *bone, const ost_geometry *g)
{
    ost_error err = {0};
    const cl_bone *b = (const cl_bone *)bone;
    const size_t n = (size_t)bone->chunk_size, words = n * n * n / 32, bytes = ost_cl_words_bytes(bone);
    uint32_t *all = malloc(bytes);
    int16_t *voxels = content(bone, g);
    assert_non_null(all);
    cl_backend *backend = (cl_backend *)bone->backend;
    assert_int_equal(shim.clEnqueueReadBuffer(backend->queue, b->words, CL_TRUE, 0, bytes, all, 0, NULL, NULL), CL_SUCCESS);
    uint32_t *one = malloc(words * sizeof *one);
    assert_non_null(one);
    for (int32_t c = 0; c < (int32_t)b->chunks; c++) {
        const uint32_t slot = ost_cl_words_slot(bone, c);
        const size_t cx = (size_t)c % (size_t)b->chunk_dims.x, cy = (size_t)c / (size_t)b->chunk_dims.x % (size_t)b->chunk_dims.y,
                     cz = (size_t)c / (size_t)b->chunk_dims.x / (size_t)b->chunk_dims.y;
        for (size_t w = 0; w < words; w++)
            one[w] = 0;
        for (size_t v = 0; v < n * n * n; v++) {
            const size_t x = cx * n + v % n, y = cy * n + v / n % n, z = cz * n + v / n / n;
            if (x < (size_t)g->dims.x && y < (size_t)g->dims.y && z < (size_t)g->dims.z &&
                voxels[x + (size_t)g->dims.x * (y + (size_t)g->dims.y * z)] > 0)
                one[v / 32] |= UINT32_C(1) << v % 32;
        }
        for (size_t w = 0; w < words; w++)
            assert_int_equal(slot == OST_CL_NONE ? 0 : all[slot * words + w], one[w]);
        if (!ost_cl_words_shared(bone)) {
            uint32_t *read = malloc(words * sizeof *read);
            assert_non_null(read);
            assert_ok(ost_cl_words_read(bone, &c, 1, read, &err));
            assert_memory_equal(read, one, words * sizeof *read);
            free(read);
        }
    }
    free(one);
    free(voxels);
    free(all);
}

typedef struct pair {
    ost_geometry g;
    int16_t *voxels;
    ost_backend *backend[2];
    ost_bone *bone[2];
    ost_tool *tool[2];
    ost_report report[2];
} pair;

static pair make_pair(ost_cl_api *api, test_rng *rng)
{
    ost_error err = {0};
    pair p = {.g = cubic_geometry(50, 40, 35, 500 * UM, (ost_pm3){0, 0, 0})};
    const ost_tool_geometry tg = {.dims = {12, 11, 10}, .voxel = 600 * UM, .corner = {-3600 * UM, -3300 * UM, -3000 * UM}};
    p.voxels = random_densities(rng, &p.g, 6);
    assert_ok(ost_backend_open("ref", &p.backend[0], &err));
    assert_ok(ost_cl_open_shared(api, own_options(), &a_context, &p.backend[1], &err));
    p.backend[1]->ops = &ost_backend_cl;
    for (int b = 0; b < 2; b++) {
        p.bone[b] = bone_of(p.backend[b], &p.g, 16, p.voxels);
        p.tool[b] = solid_tool(p.backend[b], tg, OST_TOOL_CUTTING);
    }
    return p;
}

static void free_pair(pair *p)
{
    for (int b = 0; b < 2; b++) {
        ost_report_free(&p->report[b]);
        ost_tool_free(p->tool[b]);
        ost_bone_free(p->bone[b]);
        ost_backend_close(p->backend[b]);
    }
    free(p->voxels);
}

static ost_status event_on(pair *p, int b, const ost_pose *poses, bool apply, ost_error *err)
{
    scene_event *e = malloc(sizeof *e);
    assert_non_null(e);
    const ost_event *event = event_of(e, &p->g, p->tool[b], poses, 3);
    ost_status status = apply ? ost_bone_remove(p->bone[b], p->tool[b], event, &p->report[b], err)
                              : ost_bone_collide(p->bone[b], p->tool[b], event, &p->report[b], err);
    free(e);
    return status;
}

static void some_poses(test_rng *rng, ost_pose poses[3])
{
    for (int k = 0; k < 3; k++)
        poses[k] = random_pose(rng, (ost_pm3){0, 0, 0}, (ost_pm3){25000 * UM, 20000 * UM, 17000 * UM});
}

static void assert_same(pair *p)
{
    int16_t *a = content(p->bone[0], &p->g), *b = content(p->bone[1], &p->g);
    assert_memory_equal(a, b, voxel_count(&p->g) * sizeof *a);
    free(a);
    free(b);
}

static void shared_words(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("share");
    ost_cl_api api = sharing_api();
    pair p = make_pair(&api, &rng);
    ost_pose poses[3];
    assert_words(p.bone[1], &p.g);
    const size_t bytes = ost_cl_words_bytes(p.bone[1]);
    assert_true(bytes > 0 && bytes <= 1 << 20);
    assert_int_equal(ost_cl_words_share(p.bone[1], GL_BUFFER, bytes - 1, &err), OST_ERR_RANGE);
    for (int again = 0; again < 2; again++) {
        calls[0] = 0;
        assert_ok(ost_cl_words_share(p.bone[1], GL_BUFFER, bytes, &err));
        assert_held("C");
        assert_true(ost_cl_words_shared(p.bone[1]));
        assert_int_equal(ost_cl_words_share(p.bone[1], GL_BUFFER, bytes, &err), OST_ERR_USAGE);
        assert_words(p.bone[1], &p.g);
        for (int event = 0; event < 12; event++) {
            some_poses(&rng, poses);
            for (int apply = 0; apply < 2; apply++) {
                assert_ok(event_on(&p, 0, poses, apply, &err));
                calls[0] = 0;
                assert_ok(event_on(&p, 1, poses, apply, &err));
                assert_held("K");
                assert_same_report(&p.report[0], &p.report[1]);
            }
            assert_same(&p);
            assert_words(p.bone[1], &p.g);
        }
        const ost_digest a = digest_of(p.bone[0]), b = digest_of(p.bone[1]);
        assert_memory_equal(&a, &b, sizeof a);
        calls[0] = 0;
        if (again == 0) {
            assert_ok(ost_cl_words_unshare(p.bone[1], &err));
            assert_held("C");
        } else { /* an upload unshares by itself */
            for (int s = 0; s < 2; s++)
                assert_ok(ost_bone_upload(p.bone[s], 0, p.g.dims.z, p.voxels, &err));
        }
        assert_false(ost_cl_words_shared(p.bone[1]));
        assert_null(shared);
        assert_same(&p);
        assert_words(p.bone[1], &p.g);
    }
    /* The bone is freed while its words are shared. */
    assert_ok(ost_cl_words_share(p.bone[1], GL_BUFFER, 1 << 20, &err));
    free_pair(&p);
    assert_int_equal(shim_alive(), 0);
}

static void refused_calls(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("share refused");
    ost_cl_api api = sharing_api();
    pair p = make_pair(&api, &rng);
    ost_pose poses[3];
    const size_t bytes = ost_cl_words_bytes(p.bone[1]);
    for (int what = BUFFER; what <= RELEASE; what++) {
        refused = what;
        assert_int_not_equal(ost_cl_words_share(p.bone[1], GL_BUFFER, bytes, &err), OST_OK);
        assert_non_null(strstr(err.text, "OpenCL device '"));
        assert_false(ost_cl_words_shared(p.bone[1]));
        refused = NOTHING;
        assert_same(&p);
        assert_words(p.bone[1], &p.g);
    }
    assert_ok(ost_cl_words_share(p.bone[1], GL_BUFFER, bytes, &err));
    some_poses(&rng, poses);
    refused = ACQUIRE;
    assert_int_not_equal(event_on(&p, 1, poses, true, &err), OST_OK);
    assert_int_not_equal(ost_cl_words_unshare(p.bone[1], &err), OST_OK);
    refused = NOTHING;
    assert_same(&p); /* nothing has changed */
    refused = RELEASE;
    assert_int_not_equal(event_on(&p, 1, poses, false, &err), OST_OK);
    refused = NOTHING;
    assert_same(&p); /* a collision changes nothing */
    refused = RELEASE;
    assert_int_not_equal(event_on(&p, 1, poses, true, &err), OST_OK);
    refused = NOTHING;
    assert_int_equal(event_on(&p, 1, poses, true, &err), OST_ERR_UNAVAILABLE); /* the bone is lost */
    assert_non_null(strstr(err.text, "is lost"));
    free_pair(&p);
    assert_int_equal(shim_alive(), 0);
}

/* Words cannot be shared on a backend that was opened without an OpenGL context. */
static void not_opened_for_it(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&shim, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const ost_geometry g = cubic_geometry(16, 16, 16, 500 * UM, (ost_pm3){0, 0, 0});
    test_rng rng = {5};
    int16_t *voxels = random_densities(&rng, &g, 7);
    ost_bone *bone = bone_of(backend, &g, 16, voxels);
    assert_int_equal(ost_cl_words_share(bone, GL_BUFFER, 1 << 20, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "not opened with a context"));
    ost_bone_free(bone);
    ost_backend_close(backend);
    free(voxels);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(properties),    cmocka_unit_test(not_possible),      cmocka_unit_test(shared_words),
        cmocka_unit_test(refused_calls), cmocka_unit_test(not_opened_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
