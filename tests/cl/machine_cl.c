/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A machine (machine.h) that runs the kernels on an OpenCL device without the backend. The
 * kernels are built from the sources in the tree, with warnings as errors. A launch creates its
 * buffers, runs the kernel and reads all buffers back.
 */
#include "cl/machine_cl.h"

#include <CL/cl.h>

typedef struct machine_cl {
    machine base;
    cl_device_id device;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    cl_kernel kernel[K_COUNT];
    size_t group;
} machine_cl;

static const char *const kernel_name[] = {
#define TEST_KERNEL_NAME(name) #name,
    TEST_KERNELS(TEST_KERNEL_NAME)
#undef TEST_KERNEL_NAME
};

static void check(const machine *m, cl_int code, const char *what)
{
    if (code != CL_SUCCESS)
        fail_msg("%s: %s gave %d", m->name, what, (int)code);
}

static void launch(machine *base, enum test_kernel kernel, const kernel_arg *args, unsigned count,
                   const size_t range[3])
{
    machine_cl *m = (machine_cl *)base;
    enum { ARGS = 12 };
    cl_mem buffers[ARGS] = {0};
    cl_int code;
    assert_true(count <= ARGS);
    for (unsigned i = 0; i < count; i++) {
        if (args[i].bytes == 0) {
            check(base, clSetKernelArg(m->kernel[kernel], i, sizeof args[i].number, &args[i].number),
                  kernel_name[kernel]);
            continue;
        }
        buffers[i] = clCreateBuffer(m->context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, args[i].bytes, args[i].data,
                                    &code);
        check(base, code, "clCreateBuffer");
        check(base, clSetKernelArg(m->kernel[kernel], i, sizeof buffers[i], &buffers[i]), kernel_name[kernel]);
    }
    const size_t local[3] = {m->group ? m->group : 1, 1, 1};
    const size_t global[3] = {(range[0] + local[0] - 1) / local[0] * local[0], range[1], range[2]};
    check(base,
          clEnqueueNDRangeKernel(m->queue, m->kernel[kernel], 3, NULL, global, m->group ? local : NULL, 0, NULL, NULL),
          kernel_name[kernel]);
    for (unsigned i = 0; i < count; i++)
        if (buffers[i]) {
            check(base,
                  clEnqueueReadBuffer(m->queue, buffers[i], CL_TRUE, 0, args[i].bytes, args[i].data, 0, NULL, NULL),
                  kernel_name[kernel]);
            clReleaseMemObject(buffers[i]);
        }
}

static char *source_of(const char *name)
{
    const char *top = getenv("top_srcdir");
    char path[4096];
    snprintf(path, sizeof path, "%s/src/cl/kernels/%s", top ? top : ".", name);
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("cannot read %s", path);
    enum { MOST = 1 << 18 };
    char *text = malloc(MOST);
    assert_non_null(text);
    const size_t size = fread(text, 1, MOST - 1, file);
    assert_true(size > 0 && size < MOST - 1);
    text[size] = 0;
    fclose(file);
    return text;
}

cl_program program_of(cl_context context, cl_device_id device, const char *const *names, unsigned count,
                      const char *options)
{
    char *sources[16], *log = calloc(1, 1 << 16);
    cl_int code;
    assert_true(log && count <= 16);
    for (unsigned i = 0; i < count; i++)
        sources[i] = source_of(names[i]);
    cl_program program = clCreateProgramWithSource(context, count, (const char **)(uintptr_t)sources, NULL, &code);
    assert_int_equal(code, CL_SUCCESS);
    code = clBuildProgram(program, 1, &device, options, NULL, NULL);
    if (code != CL_SUCCESS) {
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, (1 << 16) - 1, log, NULL);
        fail_msg("clBuildProgram with %s gave %d:\n%s", options, (int)code, log);
    }
    for (unsigned i = 0; i < count; i++)
        free(sources[i]);
    free(log);
    return program;
}

machine *machine_on(cl_device_id device, int rows, size_t group)
{
    static const char *const names[] = {"shared.h",  "common.h",  "chunks.cl",     "chunks_cpu.cl", "fingerprint.cl",
                                        "import.cl", "remove.cl", "remove_cpu.cl", "voxelize.cl",   "voxelize_cpu.cl"};
    machine_cl *m = calloc(1, sizeof *m);
    char name[128] = "", options[64];
    cl_int code;
    assert_non_null(m);
    clGetDeviceInfo(device, CL_DEVICE_NAME, sizeof name, name, NULL);
    snprintf(m->base.name, sizeof m->base.name, "%s, %d rows an item, groups of %zu", name, rows, group);
    m->base.rows = rows;
    m->base.launch = launch;
    m->group = group;
    m->context = clCreateContext(NULL, 1, &device, NULL, NULL, &code);
    check(&m->base, code, "clCreateContext");
    m->queue = clCreateCommandQueue(m->context, device, 0, &code);
    check(&m->base, code, "clCreateCommandQueue");
    snprintf(options, sizeof options, "-cl-std=CL1.2 -Werror -DOST_ROWS=%d", rows);
    m->program = program_of(m->context, device, names, sizeof names / sizeof *names, options);
    for (int k = 0; k < K_COUNT; k++) {
        m->kernel[k] = clCreateKernel(m->program, kernel_name[k], &code);
        check(&m->base, code, kernel_name[k]);
    }
    m->base.brief = machine_turns(&m->base) < OST_CL_TURNS;
    return &m->base;
}

void machine_off(machine *base)
{
    machine_cl *m = (machine_cl *)base;
    for (int k = 0; k < K_COUNT; k++)
        clReleaseKernel(m->kernel[k]);
    clReleaseProgram(m->program);
    clReleaseCommandQueue(m->queue);
    clReleaseContext(m->context);
    free(m);
}
