/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs the arithmetic on an OpenCL device. The device's compiler translates thesis_f32.cl.
 *
 *   plugin:thesis_f32_cl.so                      OpenCL's default: the compiler may contract
 *   plugin:thesis_f32_cl.so,contract=off         #pragma OPENCL FP_CONTRACT OFF
 *   plugin:thesis_f32_cl.so,fast=mad             -cl-mad-enable
 *   plugin:thesis_f32_cl.so,fast=relaxed         -cl-fast-relaxed-math
 *   plugin:thesis_f32_cl.so,platform=1,device=0  indices of clGetPlatformIDs and clGetDeviceIDs
 *
 * Every call creates its buffers, runs the kernels and reads the results. This is simple but
 * not fast.
 */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"

#include "thesis_f32_source.h"

const char engine_name[] = "thesis-f32-cl";
const char engine_about[] = "the thesis' float arithmetic written out in OpenCL";

struct engine {
    cl_context context;
    cl_command_queue queue;
    cl_program program;
};

/* A kernel launch. Its buffers are stored in the order of the kernel's arguments and are released together. */
enum { ARGS = 6 };
typedef struct launch {
    engine *e;
    cl_kernel kernel;
    cl_mem buffer[ARGS];
    cl_uint args;
    cl_int code;
} launch;

static void begin(launch *l, engine *e, const char *kernel)
{
    *l = (launch){.e = e};
    l->kernel = clCreateKernel(e->program, kernel, &l->code);
}

static void take(launch *l, size_t size, const void *value)
{
    if (l->code == CL_SUCCESS)
        l->code = clSetKernelArg(l->kernel, l->args, size, value);
    l->args++;
}

static void take_int(launch *l, int value)
{
    const cl_int word = value;
    take(l, sizeof word, &word);
}

static void take_float(launch *l, float value)
{
    const cl_float word = value;
    take(l, sizeof word, &word);
}

/* Creates a buffer and adds it to the launch as the next argument of the kernel. bytes is never 0. */
static void take_buffer(launch *l, size_t bytes, const void *content)
{
    const cl_uint at = l->args;
    if (l->code == CL_SUCCESS)
        l->buffer[at] = clCreateBuffer(l->e->context, CL_MEM_READ_WRITE | (content ? CL_MEM_COPY_HOST_PTR : 0), bytes,
                                       (void *)(uintptr_t)content, &l->code);
    take(l, sizeof l->buffer[at], &l->buffer[at]);
}

static void run(launch *l, size_t x, size_t y, size_t z)
{
    const size_t range[3] = {x, y, z};
    if (l->code == CL_SUCCESS)
        l->code = clEnqueueNDRangeKernel(l->e->queue, l->kernel, 3, NULL, range, NULL, 0, NULL, NULL);
}

static void fetch(launch *l, cl_uint arg, size_t bytes, void *to)
{
    if (l->code == CL_SUCCESS)
        l->code = clEnqueueReadBuffer(l->e->queue, l->buffer[arg], CL_TRUE, 0, bytes, to, 0, NULL, NULL);
}

static int32_t end(launch *l, const char *what, ost_plugin_error *error)
{
    for (int a = 0; a < ARGS; a++)
        if (l->buffer[a])
            clReleaseMemObject(l->buffer[a]);
    if (l->kernel)
        clReleaseKernel(l->kernel);
    return l->code == CL_SUCCESS
               ? OST_PLUGIN_OK
               : plugin_fail(error, OST_PLUGIN_FAILED, "OpenCL error %d at kernel %s", (int)l->code, what);
}

/* -------------------------------------------------------------------- choice */

static int number(const char *text, cl_uint *out)
{
    char *after;
    const unsigned long n = text[0] ? strtoul(text, &after, 10) : 0;
    *out = (cl_uint)n;
    return !text[0] || (*after == '\0' && n < 64 && text[0] != '-');
}

static int32_t find_device(const char *options, cl_device_id *device, ost_plugin_error *error)
{
    char platform_text[8], device_text[8];
    cl_platform_id platforms[64];
    cl_device_id devices[64];
    cl_uint platform, wanted, count = 0;
    if (!option(options, "platform", platform_text, sizeof platform_text) ||
        !option(options, "device", device_text, sizeof device_text) || !number(platform_text, &platform) ||
        !number(device_text, &wanted))
        return plugin_fail(error, OST_PLUGIN_USAGE, "'%.100s': platform= and device= are small numbers", options);
    if (clGetPlatformIDs(64, platforms, &count) != CL_SUCCESS || platform >= count)
        return plugin_fail(error, OST_PLUGIN_UNAVAILABLE,
                           "no OpenCL platform %u here; Debian has one for CPUs: pocl-opencl-icd", (unsigned)platform);
    if (clGetDeviceIDs(platforms[platform], CL_DEVICE_TYPE_ALL, 64, devices, &count) != CL_SUCCESS || wanted >= count)
        return plugin_fail(error, OST_PLUGIN_UNAVAILABLE, "OpenCL platform %u has no device %u", (unsigned)platform,
                           (unsigned)wanted);
    *device = devices[wanted];
    return OST_PLUGIN_OK;
}

static int32_t build_options(const char *options, char out[128], ost_plugin_error *error)
{
    static const char *const known[] = {"contract=", "fast=", "platform=", "device="};
    char contract[8], fast[16];
    for (const char *at = options; *at;) {
        int fits = 0;
        for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
            fits = fits || strncmp(at, known[i], strlen(known[i])) == 0;
        if (!fits)
            return plugin_fail(error, OST_PLUGIN_USAGE,
                               "'%.60s': options are contract=on|off, fast=mad|relaxed, platform=N, device=N", at);
        at += strcspn(at, ",");
        at += *at == ',';
    }
    if (!option(options, "contract", contract, sizeof contract) ||
        (contract[0] && strcmp(contract, "on") != 0 && strcmp(contract, "off") != 0))
        return plugin_fail(error, OST_PLUGIN_USAGE, "contract= is on or off");
    if (!option(options, "fast", fast, sizeof fast) ||
        (fast[0] && strcmp(fast, "mad") != 0 && strcmp(fast, "relaxed") != 0))
        return plugin_fail(error, OST_PLUGIN_USAGE, "fast= is mad or relaxed");
    snprintf(out, 128, "-cl-std=CL1.2%s%s", strcmp(contract, "off") == 0 ? " -DTHESIS_CONTRACT_OFF" : "",
             strcmp(fast, "mad") == 0       ? " -cl-mad-enable"
             : strcmp(fast, "relaxed") == 0 ? " -cl-fast-relaxed-math"
                                            : "");
    return OST_PLUGIN_OK;
}

int32_t engine_open(const char *options, engine **out, ost_plugin_error *error)
{
    char how[128];
    cl_device_id device = NULL;
    cl_int code;
    const char *text = source;
    int32_t status = build_options(options, how, error);
    if (status == OST_PLUGIN_OK)
        status = find_device(options, &device, error);
    if (status != OST_PLUGIN_OK)
        return status;
    engine *e = calloc(1, sizeof *e);
    if (!e)
        return plugin_fail(error, OST_PLUGIN_MEMORY, "no memory");
    e->context = clCreateContext(NULL, 1, &device, NULL, NULL, &code);
    e->queue = e->context ? clCreateCommandQueue(e->context, device, 0, &code) : NULL;
    e->program = e->queue ? clCreateProgramWithSource(e->context, 1, &text, NULL, &code) : NULL;
    if (!e->program || (code = clBuildProgram(e->program, 1, &device, how, NULL, NULL)) != CL_SUCCESS) {
        char log[256] = "";
        if (e->program)
            clGetProgramBuildInfo(e->program, device, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
        engine_close(e);
        return plugin_fail(error, OST_PLUGIN_UNAVAILABLE, "OpenCL error %d; the program cannot be built with %s: %s",
                           (int)code, how, log);
    }
    *out = e;
    return OST_PLUGIN_OK;
}

void engine_close(engine *e)
{
    if (e->program)
        clReleaseProgram(e->program);
    if (e->queue)
        clReleaseCommandQueue(e->queue);
    if (e->context)
        clReleaseContext(e->context);
    free(e);
}

/* -------------------------------------------------------------------- stages */

int32_t engine_index(engine *e, const float first_last_size[9], const float *samples, size_t count, thesis_rect *rect,
                     int *index, ost_plugin_error *error)
{
    launch l;
    begin(&l, e, "rect_dims");
    take_buffer(&l, 9 * sizeof(float), first_last_size);
    take_buffer(&l, sizeof *rect, NULL);
    run(&l, 1, 1, 1);
    fetch(&l, 1, sizeof *rect, rect);
    const int32_t status = end(&l, "rect_dims", error);
    if (status != OST_PLUGIN_OK || count == 0)
        return status;
    begin(&l, e, "rect_index");
    take_buffer(&l, sizeof *rect, rect);
    take_buffer(&l, count * 4 * sizeof(float), samples);
    take_buffer(&l, count * sizeof(int), NULL);
    run(&l, count, 1, 1);
    fetch(&l, 2, count * sizeof(int), index);
    return end(&l, "rect_index", error);
}

int32_t engine_layers(engine *e, float cubic, float rect, size_t count, int *layer, ost_plugin_error *error)
{
    launch l;
    begin(&l, e, "cubic_layer");
    take_float(&l, cubic);
    take_float(&l, rect);
    take_buffer(&l, count * sizeof(int), NULL);
    run(&l, count, 1, 1);
    fetch(&l, 2, count * sizeof(int), layer);
    return end(&l, "cubic_layer", error);
}

int32_t engine_minimum(engine *e, const float least[3], float size, float minimum[3], ost_plugin_error *error)
{
    launch l;
    begin(&l, e, "tool_minimum");
    for (int a = 0; a < 3; a++)
        take_float(&l, least[a]);
    take_float(&l, size);
    take_buffer(&l, 3 * sizeof(float), NULL);
    run(&l, 1, 1, 1);
    fetch(&l, 4, 3 * sizeof(float), minimum);
    return end(&l, "tool_minimum", error);
}

int32_t engine_solid(engine *e, const thesis_grid *grid, const float *corners, int mark, uint8_t *solid,
                     ost_plugin_error *error)
{
    const size_t rows = (size_t)grid->dims[1] * (size_t)grid->dims[2], count = rows * (size_t)grid->dims[0];
    launch l;
    if (grid->triangles == 0)
        return OST_PLUGIN_OK;
    begin(&l, e, "tool_rows");
    take_buffer(&l, sizeof *grid, grid);
    take_buffer(&l, (size_t)grid->triangles * 9 * sizeof(float), corners);
    take_int(&l, mark);
    take_buffer(&l, count * sizeof(int), NULL);
    take_buffer(&l, count, solid);
    run(&l, rows, 1, 1);
    fetch(&l, 4, count, solid);
    return end(&l, "tool_rows", error);
}

/* Alg. 2.10: launches one kernel for every chunk in the range. */
int32_t engine_pose(engine *e, thesis_boxes *x, const uint8_t *tool, uint8_t *marks, ost_plugin_error *error)
{
    const size_t n = (size_t)x->chunk_size,
                 tool_bytes = (size_t)x->tool_dims[0] * (size_t)x->tool_dims[1] * (size_t)x->tool_dims[2],
                 bytes = (size_t)x->bone_dims[0] * (size_t)x->bone_dims[1] * (size_t)x->bone_dims[2];
    launch l;
    begin(&l, e, "share");
    take_buffer(&l, sizeof *x, x);
    run(&l, 1, 1, 1);
    fetch(&l, 0, sizeof *x, x);
    const int32_t status = end(&l, "share", error);
    if (status != OST_PLUGIN_OK)
        return status;
    begin(&l, e, "chunk");
    take_buffer(&l, sizeof *x, x);
    take_buffer(&l, tool_bytes, tool);
    l.args = 5;
    take_buffer(&l, bytes, marks);
    for (int z = x->chunk_lo[2] < 0 ? 0 : x->chunk_lo[2]; z < x->chunk_hi[2]; z++)
        for (int y = x->chunk_lo[1] < 0 ? 0 : x->chunk_lo[1]; y < x->chunk_hi[1]; y++)
            for (int c = x->chunk_lo[0] < 0 ? 0 : x->chunk_lo[0]; c < x->chunk_hi[0]; c++) {
                l.args = 2;
                take_int(&l, c);
                take_int(&l, y);
                take_int(&l, z);
                run(&l, n, n, n);
            }
    fetch(&l, 5, bytes, marks);
    return end(&l, "chunk", error);
}
