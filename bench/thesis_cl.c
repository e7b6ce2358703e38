/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' removal in OpenCL. As in Alg. 2.10, the kernel's arguments are set again for every chunk,
 * and the host waits only at the end of the event. As in the thesis, each chunk has its own buffer, and
 * the tool's voxels are int16.
 */
#include "bench/thesis_cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

#ifdef HAVE_OPENCL
#include "bench/device_cl.h"

static const char source[] =
    "__kernel void thesis_remove(__global short *chunk, __global const short *tool, float4 to_x, float4 to_y, float4 "
    "to_z, int4 dims,\n"
    "                            int4 corner, int n)\n"
    "{\n"
    "    const int x = (int)get_global_id(0), y = (int)get_global_id(1), z = (int)get_global_id(2);\n"
    "    const float4 at = (float4)((float)(corner.x + x), (float)(corner.y + y), (float)(corner.z + z), 1.0f);\n"
    "    const float tx = dot(to_x, at), ty = dot(to_y, at), tz = dot(to_z, at);\n"
    "    if (tx < 0 || ty < 0 || tz < 0)\n"
    "        return;\n"
    "    const int ix = (int)tx, iy = (int)ty, iz = (int)tz;\n"
    "    if (ix >= dims.x || iy >= dims.y || iz >= dims.z)\n"
    "        return;\n"
    "    if (tool[ix + dims.x * (iy + dims.y * iz)] > 0)\n"
    "        chunk[x + n * (y + n * z)] = 0;\n"
    "}\n"
    "__kernel void nothing(__global short *chunk)\n"
    "{\n"
    "}\n";

struct bench_cl {
    bench_device device;
    cl_program program;
    cl_kernel remove, nothing;
    cl_mem small; /* the argument of the empty kernel */
    cl_mem tool, *chunks;
    int count;
};

static bool build(bench_cl *cl)
{
    const char *text = source;
    cl_int code;
    cl->program = clCreateProgramWithSource(cl->device.context, 1, &text, NULL, &code);
    if (!cl->program || clBuildProgram(cl->program, 1, &cl->device.id, "-cl-std=CL1.2", NULL, NULL) != CL_SUCCESS)
        return false;
    cl->remove = clCreateKernel(cl->program, "thesis_remove", &code);
    cl->nothing = clCreateKernel(cl->program, "nothing", &code);
    cl->small = clCreateBuffer(cl->device.context, CL_MEM_READ_WRITE, 64, NULL, &code);
    return cl->remove && cl->nothing && cl->small;
}

bench_cl *bench_cl_open(const char *backend, char reason[BENCH_TEXT])
{
    bench_cl *cl = calloc(1, sizeof *cl);
    if (!cl) {
        snprintf(reason, BENCH_TEXT, "no memory for the thesis' kernel");
        return NULL;
    }
    if (bench_device_open(&cl->device, backend, reason) && !build(cl))
        snprintf(reason, BENCH_TEXT, "OpenCL device '%.100s' cannot build the thesis' kernel", cl->device.name);
    if (cl->small)
        return cl;
    bench_cl_close(cl);
    return NULL;
}

static void drop_event(bench_cl *cl)
{
    for (int c = 0; c < cl->count; c++)
        if (cl->chunks[c])
            clReleaseMemObject(cl->chunks[c]);
    if (cl->tool)
        clReleaseMemObject(cl->tool);
    free(cl->chunks);
    cl->chunks = NULL;
    cl->tool = NULL;
    cl->count = 0;
}

void bench_cl_close(bench_cl *cl)
{
    if (!cl)
        return;
    drop_event(cl);
    if (cl->small)
        clReleaseMemObject(cl->small);
    if (cl->nothing)
        clReleaseKernel(cl->nothing);
    if (cl->remove)
        clReleaseKernel(cl->remove);
    if (cl->program)
        clReleaseProgram(cl->program);
    bench_device_close(&cl->device);
    free(cl);
}

const char *bench_cl_spec(const bench_cl *cl)
{
    return cl->device.spec;
}

const char *bench_cl_name(const bench_cl *cl)
{
    return cl->device.name;
}

static size_t chunk_bytes(const bench_thesis *thesis)
{
    return thesis->bytes / (size_t)thesis->event.chunk_count;
}

bool bench_cl_take(bench_cl *cl, const bench_thesis *thesis)
{
    const int32_t *d = thesis->event.dims;
    cl_int code;
    drop_event(cl);
    cl->chunks = calloc((size_t)thesis->event.chunk_count, sizeof *cl->chunks);
    cl->count = cl->chunks ? thesis->event.chunk_count : 0;
    cl->tool = clCreateBuffer(cl->device.context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                              (size_t)d[0] * (size_t)d[1] * (size_t)d[2] * sizeof *thesis->tool, thesis->tool, &code);
    bool made = cl->tool && cl->chunks;
    for (int c = 0; c < cl->count && made; c++)
        made = (cl->chunks[c] = clCreateBuffer(cl->device.context, CL_MEM_READ_WRITE, chunk_bytes(thesis), NULL,
                                               &code)) != NULL;
    return made && bench_cl_restore(cl, thesis);
}

bool bench_cl_restore(bench_cl *cl, const bench_thesis *thesis)
{
    const size_t bytes = chunk_bytes(thesis);
    bool done = true;
    for (int c = 0; c < cl->count && done; c++)
        done = clEnqueueWriteBuffer(cl->device.queue, cl->chunks[c], CL_TRUE, 0, bytes,
                                    thesis->full + (size_t)c * bytes / sizeof *thesis->full, 0, NULL,
                                    NULL) == CL_SUCCESS;
    return done;
}

bool bench_cl_fetch(bench_cl *cl, bench_thesis *thesis)
{
    bool done = true;
    for (int c = 0; c < cl->count && done; c++)
        done = clEnqueueReadBuffer(cl->device.queue, cl->chunks[c], CL_TRUE, 0, chunk_bytes(thesis), thesis->chunks[c],
                                   0, NULL, NULL) == CL_SUCCESS;
    return done;
}

bool bench_cl_remove(bench_cl *cl, const bench_thesis *thesis)
{
    const bench_thesis_event *e = &thesis->event;
    const cl_int n = e->chunk_size;
    const size_t range[3] = {(size_t)n, (size_t)n, (size_t)n};
    const cl_int4 dims = {{e->dims[0], e->dims[1], e->dims[2], 0}};
    bool done = true;
    for (int c = 0; c < cl->count && done; c++) {
        const cl_int4 corner = {{e->corners[c][0], e->corners[c][1], e->corners[c][2], 0}};
        done = clSetKernelArg(cl->remove, 0, sizeof cl->chunks[c], &cl->chunks[c]) == CL_SUCCESS;
        done = done && clSetKernelArg(cl->remove, 1, sizeof cl->tool, &cl->tool) == CL_SUCCESS;
        for (cl_uint a = 0; a < 3 && done; a++) {
            const cl_float4 row = {{e->map[a][0], e->map[a][1], e->map[a][2], e->map[a][3]}};
            done = clSetKernelArg(cl->remove, 2 + a, sizeof row, &row) == CL_SUCCESS;
        }
        done = done && clSetKernelArg(cl->remove, 5, sizeof dims, &dims) == CL_SUCCESS;
        done = done && clSetKernelArg(cl->remove, 6, sizeof corner, &corner) == CL_SUCCESS;
        done = done && clSetKernelArg(cl->remove, 7, sizeof n, &n) == CL_SUCCESS;
        done = done && clEnqueueNDRangeKernel(cl->device.queue, cl->remove, 3, NULL, range, NULL, 0, NULL, NULL) ==
                           CL_SUCCESS;
    }
    return clFinish(cl->device.queue) == CL_SUCCESS && done;
}

bool bench_cl_launch(bench_cl *cl)
{
    const size_t one = 1;
    return clSetKernelArg(cl->nothing, 0, sizeof cl->small, &cl->small) == CL_SUCCESS &&
           clEnqueueNDRangeKernel(cl->device.queue, cl->nothing, 1, NULL, &one, &one, 0, NULL, NULL) == CL_SUCCESS &&
           clFinish(cl->device.queue) == CL_SUCCESS;
}
#else
bench_cl *bench_cl_open(const char *backend, char reason[BENCH_TEXT])
{
    (void)backend;
    snprintf(reason, BENCH_TEXT, "OpenCL is not built in; Debian: ocl-icd-opencl-dev, opencl-headers");
    return NULL;
}

void bench_cl_close(bench_cl *cl)
{
    (void)cl;
}

const char *bench_cl_spec(const bench_cl *cl)
{
    (void)cl;
    return "cl";
}

const char *bench_cl_name(const bench_cl *cl)
{
    (void)cl;
    return "";
}

bool bench_cl_take(bench_cl *cl, const bench_thesis *thesis)
{
    (void)cl;
    (void)thesis;
    return false;
}

bool bench_cl_restore(bench_cl *cl, const bench_thesis *thesis)
{
    return bench_cl_take(cl, thesis);
}

bool bench_cl_remove(bench_cl *cl, const bench_thesis *thesis)
{
    return bench_cl_take(cl, thesis);
}

bool bench_cl_fetch(bench_cl *cl, bench_thesis *thesis)
{
    return bench_cl_take(cl, thesis);
}

bool bench_cl_launch(bench_cl *cl)
{
    (void)cl;
    return false;
}
#endif
