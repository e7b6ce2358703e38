/* SPDX-License-Identifier: Apache-2.0 */
/* Manages the buffers and launches of the tool-to-bone methods on an OpenCL device. */
#include "reproduction/methods/points_cl.h"

#ifdef HAVE_OPENCL
#include <stdlib.h>

static ost_status make_blocks(points_cl *s, ost_error *err)
{
    const size_t count = (size_t)s->points.block_count;
    cl_int *at = malloc(8 * (count + 1) * sizeof *at);
    if (!at)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu blocks of points", count);
    for (size_t b = 0; b < count; b++) {
        const points_block *from = &s->points.blocks[b];
        at[8 * b] = from->first;
        at[8 * b + 1] = from->count;
        for (int a = 0; a < 3; a++) {
            at[8 * b + 2 + (size_t)a] = from->lo[a];
            at[8 * b + 5 + (size_t)a] = from->hi[a];
        }
    }
    cl_int code;
    s->blocks = clCreateBuffer(s->device->cl.context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                               8 * (count + (count == 0)) * sizeof *at, at, &code);
    free(at);
    return method_device_check(code, "clCreateBuffer of the blocks", err);
}

static ost_status make_points(points_cl *s, ost_error *err)
{
    const size_t count = (size_t)s->points.count;
    cl_short4 *at = calloc(count + 1, sizeof *at);
    if (!at)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu points", count);
    for (size_t n = 0; n < count; n++)
        for (int a = 0; a < 3; a++)
            at[n].s[a] = s->points.e[a][n];
    cl_int code;
    s->buffer = clCreateBuffer(s->device->cl.context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                               (count + 1) * sizeof *at, at, &code);
    free(at);
    return method_device_check(code, "clCreateBuffer of the points", err);
}

static ost_status make_bone(points_cl *s, ost_error *err)
{
    const size_t bytes = (size_t)ost_dims_count(s->scene->event.bone.dims) * sizeof *s->scene->voxels;
    cl_int code;
    s->bone = clCreateBuffer(s->device->cl.context, CL_MEM_READ_WRITE, bytes, NULL, &code);
    ost_status status = method_device_check(code, "clCreateBuffer of the bone", err);
    if (status == OST_OK)
        status = method_device_check(
            clEnqueueWriteBuffer(s->device->cl.queue, s->bone, CL_TRUE, 0, bytes, s->scene->voxels, 0, NULL, NULL),
            "clEnqueueWriteBuffer of the bone", err);
    return status;
}

ost_status points_cl_open(const methods_scene *scene, const method_setup *setup, int block, const char *source,
                          const char *kernel, points_cl **out, ost_error *err)
{
    points_cl *s = calloc(1, sizeof *s);
    cl_int code = CL_SUCCESS;
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->scene = scene;
    s->device = setup->device;
    ost_status status = OST_OK;
    if (ost_dims_count(scene->event.bone.dims) >= UINT32_MAX)
        status = ost_fail(err, OST_ERR_RANGE, "a bone of 2^32 voxels or more; tool points index 32 bits");
    if (status == OST_OK)
        status = method_points_init(&s->points, &scene->event.tool, setup->points, block, err);
    if (status == OST_OK)
        status = method_device_build(s->device, source, &s->program, err);
    if (status == OST_OK) {
        s->kernel = clCreateKernel(s->program, kernel, &code);
        status = method_device_check(code, "clCreateKernel", err);
    }
    if (status == OST_OK)
        status = make_points(s, err);
    if (status == OST_OK && block)
        status = make_blocks(s, err);
    if (status == OST_OK)
        status = make_bone(s, err);
    if (status == OST_OK)
        *out = s;
    else
        points_cl_close(s);
    return status;
}

void points_cl_close(void *state)
{
    points_cl *s = state;
    if (s->bone)
        clReleaseMemObject(s->bone);
    if (s->buffer)
        clReleaseMemObject(s->buffer);
    if (s->blocks)
        clReleaseMemObject(s->blocks);
    if (s->kernel)
        clReleaseKernel(s->kernel);
    if (s->program)
        clReleaseProgram(s->program);
    method_points_free(&s->points);
    free(s);
}

/* The scene's region, as arguments of a copy between two buffers with the layout of the bone. */
typedef struct rect {
    /* origin and size are in bytes along x, in rows along y, and in slices along z */
    size_t origin[3], size[3], row, slice;
} rect;

static rect region_of(const points_cl *s)
{
    const ost_voxel_box *r = &s->scene->region;
    const size_t row = (size_t)s->scene->event.bone.dims.x * sizeof(int16_t);
    rect out = {.row = row, .slice = row * (size_t)s->scene->event.bone.dims.y};
    for (int a = 0; a < 3; a++) {
        const size_t bytes = a == 0 ? sizeof(int16_t) : 1;
        out.origin[a] = (size_t)r->lo[a] * bytes;
        out.size[a] = (size_t)(r->hi[a] - r->lo[a]) * bytes;
    }
    return out;
}

ost_status points_cl_restore(void *state, ost_error *err)
{
    points_cl *s = state;
    const rect r = region_of(s);
    const ost_voxel_box nothing = {.hi = {0, 0, 0}};
    if (method_box_count(&s->scene->region) == 0)
        return OST_OK;
    ost_status status = method_device_check(
        clEnqueueWriteBufferRect(s->device->cl.queue, s->bone, CL_TRUE, r.origin, r.origin, r.size, r.row, r.slice,
                                 r.row, r.slice, s->scene->voxels, 0, NULL, NULL),
        "clEnqueueWriteBufferRect", err);
    /* A blocking write may return before the data is on the device. This launch waits for the data and reads all
       points. It removes nothing, because the box is empty. */
    const size_t items = s->blocks ? (size_t)s->points.block_count * 64 : points_cl_items(s->points.count);
    if (status == OST_OK)
        status = points_cl_run(s, &nothing, 0, s->points.count, items, s->blocks ? 64 : 0, err);
    return status;
}

ost_status points_cl_result(void *state, method_set *set, ost_error *err)
{
    points_cl *s = state;
    const rect r = region_of(s);
    const size_t none[3] = {0, 0, 0}, count = method_box_count(&set->box);
    if (count == 0)
        return OST_OK;
    int16_t *voxels = malloc(count * sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a region of %zu voxels", count);
    ost_status status = method_device_check(
        clEnqueueReadBufferRect(s->device->cl.queue, s->bone, CL_TRUE, r.origin, none, r.size, r.row, r.slice,
                                r.size[0], r.size[0] * r.size[1], voxels, 0, NULL, NULL),
        "clEnqueueReadBufferRect", err);
    if (status == OST_OK)
        method_set_add_removed(set, s->scene, voxels);
    free(voxels);
    return status;
}

void points_cl_work(void *state, method_work *out)
{
    const points_cl *s = state;
    *out = (method_work){.visited = s->visited,
                         .bone_bytes = ost_dims_count(s->scene->event.bone.dims) * (int64_t)sizeof(int16_t),
                         .index_bytes = s->points.block_count * (int64_t)(8 * sizeof(cl_int)),
                         .tool_bytes = s->points.count * (int64_t)sizeof(cl_short4)};
}

static cl_int4 int4_of(const int32_t v[3], int32_t w)
{
    return (cl_int4){{v[0], v[1], v[2], w}};
}

ost_status points_cl_run(points_cl *s, const ost_voxel_box *box, int32_t first, int32_t count, size_t items,
                         size_t group, ost_error *err)
{
    const bench_scene *event = &s->scene->event;
    const ost_dims d = event->bone.dims;
    const int32_t dims[3] = {d.x, d.y, d.z};
    points_map map;
    ost_status status = points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, err);
    if (status != OST_OK || items == 0)
        return status;
    const cl_int4 base = int4_of(map.base, map.fraction), anchor = int4_of(map.anchor, 0);
    const cl_int4 size = int4_of(dims, 0), lo = int4_of(box->lo, 0), hi = int4_of(box->hi, 0);
    cl_int4 to[3];
    for (int b = 0; b < 3; b++)
        to[b] = (cl_int4){{map.step[0][b], map.step[1][b], map.step[2][b], 0}};
    cl_int code = clSetKernelArg(s->kernel, 0, sizeof s->bone, &s->bone);
    code |= clSetKernelArg(s->kernel, 1, sizeof s->buffer, &s->buffer);
    code |= clSetKernelArg(s->kernel, 2, sizeof base, &base);
    code |= clSetKernelArg(s->kernel, 3, sizeof anchor, &anchor);
    for (cl_uint b = 0; b < 3; b++)
        code |= clSetKernelArg(s->kernel, 4 + b, sizeof to[b], &to[b]);
    code |= clSetKernelArg(s->kernel, 7, sizeof size, &size);
    code |= clSetKernelArg(s->kernel, 8, sizeof lo, &lo);
    code |= clSetKernelArg(s->kernel, 9, sizeof hi, &hi);
    code |= clSetKernelArg(s->kernel, 10, sizeof first, &first);
    code |= clSetKernelArg(s->kernel, 11, sizeof count, &count);
    if (s->blocks)
        code |= clSetKernelArg(s->kernel, 12, sizeof s->blocks, &s->blocks);
    status = method_device_check(code, "clSetKernelArg", err);
    if (status == OST_OK)
        status = method_device_check(clEnqueueNDRangeKernel(s->device->cl.queue, s->kernel, 1, NULL, &items,
                                                            group ? &group : NULL, 0, NULL, NULL),
                                     "clEnqueueNDRangeKernel", err);
    if (status == OST_OK)
        status = method_device_check(clFinish(s->device->cl.queue), "clFinish", err);
    return status;
}
#else
typedef int points_cl_is_empty; /* ISO C forbids an empty translation unit */
#endif
