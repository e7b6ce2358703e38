/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the kernels on every OpenCL device of this machine with the reference. The results must be bit-identical for
 * several values of rows per item and several work-group sizes. The test is skipped if there is no device.
 *
 *   OST_TEST_DEVICE=text   tests only devices whose name contains text
 *   OST_TEST_ROUNDS=n      tests n small scenes of each kind; for a simulator, for example:
 *
 *   OST_TEST_DEVICE=Oclgrind OST_TEST_ROUNDS=2 oclgrind --build-options -cl-opt-disable \
 *       --data-races --uninitialized tests/cl/test_kernels_on_devices
 *
 * (Optimisation is off because Oclgrind lacks llvm.abs and other intrinsics that the optimiser generates.)
 *
 * Covers: AR-INT-2, AR-CT-4, AR-CT-5, AR-CT-6, AR-CUB-2, AR-CHK-1, AR-CHK-4, AR-VOX-1..7, AR-MAP-4,
 * AR-REM-1..6, AR-LAW-1, REQ-CL
 */
#include "cl/machine_cl.h"

enum { DEVICES = 16 };
static cl_device_id devices[DEVICES];
static int device_count;

static void find_devices(void)
{
    cl_platform_id platforms[8];
    cl_uint platform_count = 0;
    const char *only = getenv("OST_TEST_DEVICE");
    if (clGetPlatformIDs(8, platforms, &platform_count) != CL_SUCCESS)
        return;
    for (cl_uint p = 0; p < platform_count && p < 8; p++) {
        cl_uint count = 0;
        cl_device_id found[DEVICES];
        if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, DEVICES, found, &count) != CL_SUCCESS)
            continue;
        for (cl_uint d = 0; d < count && device_count < DEVICES; d++) {
            char name[200] = "";
            clGetDeviceInfo(found[d], CL_DEVICE_NAME, sizeof name, name, NULL);
            if (!only || strstr(name, only))
                devices[device_count++] = found[d];
        }
    }
}

/* Group sizes are fixed, because PoCL compiles a kernel again for every new size. */
static const struct {
    int rows;
    size_t group;
} ways[] = {{256, 1}, {1, 64}, {16, 16}, {4, 7}};
/* A simulator runs only the first SMALL_WAYS entries of the table: removal by blocks and removal by rows. */
enum { WAYS = sizeof ways / sizeof *ways, SMALL_WAYS = 2 };
static machine *machines[DEVICES * WAYS];
static int machine_count, rounds_given;

static int open_machines(void **state)
{
    (void)state;
    const char *given = getenv("OST_TEST_ROUNDS");
    rounds_given = given ? atoi(given) : 0;
    for (int d = 0; d < device_count; d++)
        for (int w = 0; w < (rounds_given ? SMALL_WAYS : WAYS); w++) {
            machines[machine_count] = machine_on(devices[d], ways[w].rows, ways[w].group);
            machines[machine_count++]->small = rounds_given > 0;
        }
    return 0;
}

static int close_machines(void **state)
{
    (void)state;
    while (machine_count > 0)
        machine_off(machines[--machine_count]);
    return 0;
}

static void on_devices(const char *what, void (*compare)(machine *, test_rng *, int), int rounds)
{
    test_rng rng = rng_seeded(what);
    for (int i = 0; i < machine_count; i++)
        compare(machines[i], &rng, rounds_given ? rounds_given : rounds);
}

static void samples(void **state) { (void)state; on_devices("samples to rect grid", compare_scatter, 20); }
static void cubic(void **state) { (void)state; on_devices("rect grid to cubic", compare_cubic, 8); }
static void chunks(void **state) { (void)state; on_devices("chunks", compare_chunks, 4); }
static void voxelizer(void **state) { (void)state; on_devices("voxelizer", compare_voxelizer, 20); }
static void reach(void **state) { (void)state; on_devices("reach of cells", compare_reach, 4); }
static void removal(void **state) { (void)state; on_devices("removal", compare_removal, 16); }
static void fingerprint(void **state) { (void)state; on_devices("fingerprint", compare_fingerprint, 1); }

/* The program with floating-point computations must build and run. Its results are printed but not checked. */
static void floats(void **state)
{
    (void)state;
    static const char *const names[] = {"shared.h", "fingerprint_float.cl"};
    const uint32_t in[6] = {0x3f800001, 0x3f7fffff, 0xbf800000, 0x40490fdb, 0x3dcccccd, 0x33800000};
    for (int d = 0; d < device_count; d++) {
        cl_int code;
        uint32_t out[2 * OST_CL_FLOATS] = {0};
        const cl_uint count = 2;
        cl_context context = clCreateContext(NULL, 1, &devices[d], NULL, NULL, &code);
        assert_int_equal(code, CL_SUCCESS);
        cl_command_queue queue = clCreateCommandQueue(context, devices[d], 0, &code);
        assert_int_equal(code, CL_SUCCESS);
        cl_program program = program_of(context, devices[d], names, 2, "-cl-std=CL1.2 -Werror");
        cl_kernel kernel = clCreateKernel(program, "ost_fingerprint_float", &code);
        assert_int_equal(code, CL_SUCCESS);
        cl_mem from = clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, sizeof in, (void *)(uintptr_t)in,
                                     &code);
        cl_mem to = clCreateBuffer(context, CL_MEM_WRITE_ONLY, sizeof out, NULL, &code);
        const size_t range = count;
        assert_int_equal(clSetKernelArg(kernel, 0, sizeof count, &count), CL_SUCCESS);
        assert_int_equal(clSetKernelArg(kernel, 1, sizeof from, &from), CL_SUCCESS);
        assert_int_equal(clSetKernelArg(kernel, 2, sizeof to, &to), CL_SUCCESS);
        assert_int_equal(clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &range, NULL, 0, NULL, NULL), CL_SUCCESS);
        assert_int_equal(clEnqueueReadBuffer(queue, to, CL_TRUE, 0, sizeof out, out, 0, NULL, NULL), CL_SUCCESS);
        printf("# device %d:", d);
        for (int i = 0; i < OST_CL_FLOATS; i++)
            printf(" %08x", out[i]);
        printf("\n");
        clReleaseMemObject(from);
        clReleaseMemObject(to);
        clReleaseKernel(kernel);
        clReleaseProgram(program);
        clReleaseCommandQueue(queue);
        clReleaseContext(context);
    }
}

int main(void)
{
    /* rusticl is off by default. It is tested because Mesa's compiler is independent of other drivers' compilers. */
    setenv("RUSTICL_ENABLE", "llvmpipe", 0);
    find_devices();
    if (device_count == 0) {
        printf("no OpenCL device here\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples),     cmocka_unit_test(cubic),  cmocka_unit_test(chunks),
        cmocka_unit_test(voxelizer),   cmocka_unit_test(reach),  cmocka_unit_test(removal),
        cmocka_unit_test(fingerprint), cmocka_unit_test(floats),
    };
    return cmocka_run_group_tests(tests, open_machines, close_machines);
}
