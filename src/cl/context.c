/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens one device: creates the context, the queue, the program and the kernels, and runs
 * the two checks that the device must pass before it computes anything.
 */
#include "cl/cl.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/embedded.h"

static const struct {
    const char *name;
    int sets;
} kernels[] = {
#define OST_CL_KERNEL_TEXT(name, sets) {#name, sets},
    OST_CL_KERNELS(OST_CL_KERNEL_TEXT)
#undef OST_CL_KERNEL_TEXT
};

static ost_cl_set set_of(const cl_backend *b)
{
    return b->cpu_set ? OST_CL_SET_CPU : OST_CL_SET_GPU;
}

void ost_cl_paths(const ost_backend *base, ost_path_visit *visit, void *user)
{
    static const struct {
        const char *name;
        int sets;
    } paths[] = {
#define OST_CL_PATH_TEXT(path, sets, name) {name, sets},
        OST_CL_PATHS(OST_CL_PATH_TEXT)
#undef OST_CL_PATH_TEXT
    };
    const cl_backend *b = (const cl_backend *)base;
    char name[OST_PATH_NAME];
    for (int k = 0; k < OST_CL_KERNEL_COUNT; k++)
        if (b->kernel[k]) {
            snprintf(name, sizeof name, "kernel %s", kernels[k].name);
            visit(user, name, b->launched[k]);
        }
    for (int p = 0; p < OST_CL_PATH_COUNT; p++)
        if (paths[p].sets & (int)set_of(b))
            visit(user, paths[p].name, b->entered[p]);
}

static ost_status create_kernels(cl_backend *b, ost_error *err)
{
    for (int k = 0; k < OST_CL_KERNEL_COUNT; k++) {
        const char *name = kernels[k].name;
        cl_int code = CL_SUCCESS;
        if (!(kernels[k].sets & (int)set_of(b)))
            continue;
        b->kernel[k] = b->cl->clCreateKernel(b->program, name, &code);
        if (!b->kernel[k] || code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clCreateKernel", name);
        code = b->cl->clGetKernelWorkGroupInfo(b->kernel[k], b->device.id, CL_KERNEL_WORK_GROUP_SIZE,
                                               sizeof b->kernel_workgroup[k], &b->kernel_workgroup[k], NULL);
        if (code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clGetKernelWorkGroupInfo", name);
    }
    return OST_OK;
}

static void drop_program(cl_backend *b)
{
    for (int k = 0; k < OST_CL_KERNEL_COUNT; k++)
        if (b->kernel[k])
            b->cl->clReleaseKernel(b->kernel[k]);
    memset(b->kernel, 0, sizeof b->kernel);
    if (b->program)
        b->cl->clReleaseProgram(b->program);
    b->program = NULL;
}

/* Builds the program for the backend's kernel set, creates the kernels, and runs the two checks. */
static ost_status set_up_program(cl_backend *b, ost_error *err)
{
    char options[96], order[32] = "";
    b->run = b->cpu_set ? 1024 : 1;
    if (b->order)
        snprintf(order, sizeof order, " -DOST_ORDER=%uu", b->order);
    snprintf(options, sizeof options, "-cl-std=CL1.2 -DOST_FOR=%d -DOST_ROWS=1 -DOST_RUN=%d%s", b->cpu_set ? 2 : 1,
             b->run, order);
    ost_status status = ost_cl_build(b, ost_cl_program, ost_cl_program_count, options, &b->program, &b->from_cache,
                                     err);
    if (status == OST_OK)
        status = create_kernels(b, err);
    if (status == OST_OK)
        status = ost_cl_layout_check(b, err);
    if (status == OST_OK)
        status = ost_cl_fingerprint_check(b, err);
    return status;
}

/*
 * Creates the context, the queue and the program. If the device ends long loops, the kernel set for CPUs is replaced by
 * the one for GPUs. If `chosen` is true, the user has selected the kernel set, and the function returns an error
 * instead.
 */
static ost_status set_up(cl_backend *b, bool chosen, ost_error *err)
{
    cl_int code = CL_SUCCESS;
    const cl_context_properties properties[] = {CL_CONTEXT_PLATFORM, (cl_context_properties)b->device.platform, 0};
    b->context = b->cl->clCreateContext(properties, 1, &b->device.id, NULL, NULL, &code);
    if (!b->context || code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clCreateContext", "");
    b->queue = b->cl->clCreateCommandQueue(b->context, b->device.id, 0, &code);
    if (!b->queue || code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clCreateCommandQueue", "");
    ost_status status = set_up_program(b, err);
    if (status == OST_OK && b->cpu_set && b->turns < OST_CL_TURNS && chosen)
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "OpenCL device '%.120s' ends a loop after %u iterations, too early for kernels=cpu; use "
                        "kernels=gpu", b->device.name, (unsigned)b->turns);
    /* The kernels for CPUs need long loops, so a device that ends them gets the kernels for GPUs. */
    if (status == OST_OK && b->cpu_set && b->turns < OST_CL_TURNS) {
        b->cpu_set = false;
        drop_program(b);
        status = set_up_program(b, err);
    }
    return status;
}

ost_status ost_cl_device_open(const ost_cl_api *cl, const ost_cl_device *device, const ost_cl_options *options,
                              cl_backend **out, ost_error *err)
{
    *out = NULL;
    if (device->reason[0])
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL device '%.120s' is refused: %s",
                        device->id ? device->name : device->platform_name, device->reason);
    if (options->workgroup > device->max_workgroup)
        return ost_fail(err, OST_ERR_USAGE, "backend cl: workgroup=%zu; '%.120s' takes at most %zu", options->workgroup,
                        device->name, device->max_workgroup);
    cl_backend *b = calloc(1, sizeof *b);
    int16_t *zeros = calloc(OST_LEAF * OST_LEAF * OST_LEAF, sizeof *zeros);
    ost_status status = OST_OK;
    if (!b || !zeros)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for backend cl");
    else
        status = ost_digest_leaf16(zeros, &b->empty_leaf, err);
    free(zeros);
    if (status == OST_OK) {
        b->cl = cl;
        b->device = *device;
        b->workgroup = options->workgroup;
        b->staging = options->staging;
        b->order = options->order;
        b->cpu_set = options->kernels == OST_CL_SET_AUTO ? device->cpu : options->kernels == OST_CL_SET_CPU;
        /* A driver may install a handler for SIGFPE, as PoCL does. The handler would hide a division by zero in the
           rest of the process, so the previous handler is restored. */
        struct sigaction before;
        const bool known = sigaction(SIGFPE, NULL, &before) == 0;
        status = set_up(b, options->kernels != OST_CL_SET_AUTO, err);
        if (known)
            sigaction(SIGFPE, &before, NULL);
    }
    if (status != OST_OK) {
        ost_cl_device_close(b);
        return status;
    }
    *out = b;
    return OST_OK;
}

void ost_cl_device_close(cl_backend *b)
{
    if (!b)
        return;
    if (b->queue)
        b->cl->clFinish(b->queue);
    ost_cl_spare_clear(b);
    drop_program(b);
    if (b->queue)
        b->cl->clReleaseCommandQueue(b->queue);
    if (b->context)
        b->cl->clReleaseContext(b->context);
    free(b);
}
