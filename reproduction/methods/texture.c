/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bone and tool as 3D textures (thesis, section 2.2). Before OpenCL 2.0, a kernel cannot read and write the same image,
 * so an event consists of two kernels.
 *
 *   mark    for each voxel of the box: read the bone's image and the tool's image; write a mask into a buffer
 *   clear   for each voxel of the box with a mask: write 0 into the bone's image
 *
 * The bone is an image of int16, and the tool is an image of uint8, in which positions outside the grid read as 0.
 * A device must support images, and kernels must be able to write 3D images (cl_khr_3d_image_writes).
 */
#include "reproduction/methods/matrix.h"
#include "reproduction/methods/device.h"

#ifdef HAVE_OPENCL
#include <stdlib.h>
#include <string.h>

static const char source[] =
    "#pragma OPENCL EXTENSION cl_khr_3d_image_writes : enable\n"
    "__constant sampler_t nearest = CLK_NORMALIZED_COORDS_FALSE | CLK_ADDRESS_CLAMP | CLK_FILTER_NEAREST;\n"
    "__kernel void mark(__read_only image3d_t bone, __read_only image3d_t tool, __global uchar *mask,\n"
    "    __global const int *base, int4 to_x, int4 to_y, int4 to_z, int4 lo, int4 first, int4 count)\n"
    "{\n"
    "    const int x = (int)get_global_id(0), y = (int)get_global_id(1), z = (int)get_global_id(2);\n"
    "    const size_t at = x + get_global_size(0) * (y + get_global_size(1) * z);\n"
    "    const int4 v = (int4)(lo.x + x, lo.y + y, lo.z + z, 0);\n"
    "    uchar hit = 0;\n"
    "    if (read_imagei(bone, nearest, v).x != 0) {\n"
    "        const int4 block = (v >> 4) - first, d = v & 15;\n"
    "        __global const int *b = base + 3 * (block.x + count.x * (block.y + count.y * block.z));\n"
    "        const int4 u = (int4)(b[0] + d.x * to_x.x + d.y * to_x.y + d.z * to_x.z,\n"
    "                              b[1] + d.x * to_y.x + d.y * to_y.y + d.z * to_y.z,\n"
    "                              b[2] + d.x * to_z.x + d.y * to_z.y + d.z * to_z.z, 0) >> 20;\n"
    "        hit = (uchar)read_imageui(tool, nearest, u).x;\n"
    "    }\n"
    "    mask[at] = hit;\n"
    "}\n"
    "__kernel void clear(__write_only image3d_t bone, __global const uchar *mask, int4 lo)\n"
    "{\n"
    "    const int x = (int)get_global_id(0), y = (int)get_global_id(1), z = (int)get_global_id(2);\n"
    "    if (mask[x + get_global_size(0) * (y + get_global_size(1) * z)])\n"
    "        write_imagei(bone, (int4)(lo.x + x, lo.y + y, lo.z + z, 0), (int4)(0));\n"
    "}\n";

typedef struct texture {
    const methods_scene *scene;
    struct method_device *device; /* borrowed */
    cl_program program;
    cl_kernel mark, clear;
    cl_mem bone, tool, mask, base;
    matrix_map map;
} texture;

static void close_texture(void *state)
{
    texture *s = state;
    const cl_mem memory[] = {s->bone, s->tool, s->mask, s->base};
    for (size_t m = 0; m < sizeof memory / sizeof memory[0]; m++)
        if (memory[m])
            clReleaseMemObject(memory[m]);
    if (s->mark)
        clReleaseKernel(s->mark);
    if (s->clear)
        clReleaseKernel(s->clear);
    if (s->program)
        clReleaseProgram(s->program);
    matrix_map_free(&s->map);
    free(s);
}

static ost_status check_device(const texture *s, ost_error *err)
{
    char extensions[8192] = "";
    cl_bool images = CL_FALSE;
    clGetDeviceInfo(s->device->cl.id, CL_DEVICE_IMAGE_SUPPORT, sizeof images, &images, NULL);
    clGetDeviceInfo(s->device->cl.id, CL_DEVICE_EXTENSIONS, sizeof extensions - 1, extensions, NULL);
    if (images && strstr(extensions, "cl_khr_3d_image_writes"))
        return OST_OK;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL device '%.100s' cannot write 3D images", s->device->cl.name);
}

static cl_mem make_image(const texture *s, ost_dims d, cl_channel_type type, cl_mem_flags flags, void *voxels,
                         cl_int *code)
{
    const cl_image_format format = {.image_channel_order = CL_R, .image_channel_data_type = type};
    const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE3D, .image_width = (size_t)d.x,
                                .image_height = (size_t)d.y, .image_depth = (size_t)d.z};
    return clCreateImage(s->device->cl.context, flags | CL_MEM_COPY_HOST_PTR, &format, &desc, voxels, code);
}

/* Makes the images, and the buffers of the mask and of the map's bases. */
static ost_status make_memory(texture *s, ost_error *err)
{
    const bench_scene *event = &s->scene->event;
    const size_t tool_count = (size_t)ost_dims_count(event->tool.geometry.dims);
    const size_t box = method_box_count(&event->box) + 1;
    cl_int codes[4] = {0};
    uint8_t *cutting = malloc(tool_count);
    if (!cutting)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool");
    for (size_t v = 0; v < tool_count; v++)
        cutting[v] = event->tool.voxels[v] == OST_TOOL_CUTTING;
    s->bone = make_image(s, event->bone.dims, CL_SIGNED_INT16, CL_MEM_READ_WRITE, s->scene->voxels, &codes[0]);
    s->tool = make_image(s, event->tool.geometry.dims, CL_UNSIGNED_INT8, CL_MEM_READ_ONLY, cutting, &codes[1]);
    free(cutting);
    s->mask = clCreateBuffer(s->device->cl.context, CL_MEM_READ_WRITE, box, NULL, &codes[2]);
    ost_status status = matrix_map_make(&s->map, &event->map, &event->box, err);
    if (status != OST_OK)
        return status;
    s->base = clCreateBuffer(s->device->cl.context, CL_MEM_READ_ONLY, (s->map.capacity + 1) * sizeof *s->map.base,
                             NULL, &codes[3]);
    for (int c = 0; c < 4 && status == OST_OK; c++)
        status = method_device_check(codes[c], "clCreateImage or clCreateBuffer", err);
    return status;
}

static ost_status open_texture(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    texture *s = calloc(1, sizeof *s);
    cl_int code = CL_SUCCESS;
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->scene = scene;
    s->device = setup->device;
    ost_status status = check_device(s, err);
    if (status == OST_OK)
        status = method_device_build(s->device, source, &s->program, err);
    if (status == OST_OK) {
        s->mark = clCreateKernel(s->program, "mark", &code);
        status = method_device_check(code, "clCreateKernel", err);
    }
    if (status == OST_OK) {
        s->clear = clCreateKernel(s->program, "clear", &code);
        status = method_device_check(code, "clCreateKernel", err);
    }
    if (status == OST_OK)
        status = make_memory(s, err);
    if (status == OST_OK)
        *state = s;
    else
        close_texture(s);
    return status;
}

static void region_of(const methods_scene *scene, size_t origin[3], size_t size[3])
{
    for (int a = 0; a < 3; a++) {
        origin[a] = (size_t)scene->region.lo[a];
        size[a] = (size_t)(scene->region.hi[a] - scene->region.lo[a]);
    }
}

static ost_status run_event(texture *s, bool clear, ost_error *err);

/* Restores the bone's image. A blocking write may return before the data is on the device, so the kernel that marks
   voxels is then run. It waits for the data and reads the event's part of the image, but removes nothing. */
static ost_status restore(void *state, ost_error *err)
{
    texture *s = state;
    const ost_dims d = s->scene->event.bone.dims;
    size_t origin[3], size[3];
    if (method_box_count(&s->scene->region) == 0)
        return OST_OK;
    region_of(s->scene, origin, size);
    const int16_t *from = s->scene->voxels + origin[0] + (size_t)d.x * (origin[1] + (size_t)d.y * origin[2]);
    const size_t row = (size_t)d.x * sizeof *from;
    ost_status status = method_device_check(clEnqueueWriteImage(s->device->cl.queue, s->bone, CL_TRUE, origin, size,
                                                                row, row * (size_t)d.y, from, 0, NULL, NULL),
                                            "clEnqueueWriteImage", err);
    return status == OST_OK ? run_event(s, false, err) : status;
}

static ost_status set_arguments(texture *s, ost_error *err)
{
    const matrix_map *m = &s->map;
    const int32_t *lo = s->scene->event.box.lo;
    const cl_int4 corner = {{lo[0], lo[1], lo[2], 0}}, first = {{m->first[0], m->first[1], m->first[2], 0}},
                  count = {{m->count[0], m->count[1], m->count[2], 0}};
    cl_int code = clSetKernelArg(s->mark, 0, sizeof s->bone, &s->bone);
    code |= clSetKernelArg(s->mark, 1, sizeof s->tool, &s->tool);
    code |= clSetKernelArg(s->mark, 2, sizeof s->mask, &s->mask);
    code |= clSetKernelArg(s->mark, 3, sizeof s->base, &s->base);
    for (cl_uint a = 0; a < 3; a++) {
        const cl_int4 to = {{m->step[0][a], m->step[1][a], m->step[2][a], 0}};
        code |= clSetKernelArg(s->mark, 4 + a, sizeof to, &to);
    }
    code |= clSetKernelArg(s->mark, 7, sizeof corner, &corner);
    code |= clSetKernelArg(s->mark, 8, sizeof first, &first);
    code |= clSetKernelArg(s->mark, 9, sizeof count, &count);
    code |= clSetKernelArg(s->clear, 0, sizeof s->bone, &s->bone);
    code |= clSetKernelArg(s->clear, 1, sizeof s->mask, &s->mask);
    code |= clSetKernelArg(s->clear, 2, sizeof corner, &corner);
    return method_device_check(code, "clSetKernelArg", err);
}

/* Runs the kernel that marks voxels and, if `clear` is true, the kernel that removes the marked voxels. */
static ost_status run_event(texture *s, bool clear, ost_error *err)
{
    const bench_scene *event = &s->scene->event;
    cl_command_queue queue = s->device->cl.queue;
    size_t range[3];
    if (method_box_count(&event->box) == 0)
        return OST_OK;
    for (int a = 0; a < 3; a++)
        range[a] = (size_t)(event->box.hi[a] - event->box.lo[a]);
    ost_status status = matrix_map_make(&s->map, &event->map, &event->box, err);
    if (status != OST_OK)
        return status;
    const size_t bases = (size_t)s->map.count[0] * (size_t)s->map.count[1] * (size_t)s->map.count[2];
    status = method_device_check(clEnqueueWriteBuffer(queue, s->base, CL_FALSE, 0, bases * sizeof *s->map.base,
                                                      s->map.base, 0, NULL, NULL),
                                 "clEnqueueWriteBuffer", err);
    if (status == OST_OK)
        status = set_arguments(s, err);
    if (status == OST_OK)
        status = method_device_check(clEnqueueNDRangeKernel(queue, s->mark, 3, NULL, range, NULL, 0, NULL, NULL),
                                     "clEnqueueNDRangeKernel", err);
    if (status == OST_OK && clear)
        status = method_device_check(clEnqueueNDRangeKernel(queue, s->clear, 3, NULL, range, NULL, 0, NULL, NULL),
                                     "clEnqueueNDRangeKernel", err);
    if (status == OST_OK)
        status = method_device_check(clFinish(queue), "clFinish", err);
    return status;
}

static ost_status remove_event(void *state, ost_error *err)
{
    return run_event(state, true, err);
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    texture *s = state;
    const size_t count = method_box_count(&set->box);
    size_t origin[3], size[3];
    if (count == 0)
        return OST_OK;
    int16_t *voxels = malloc(count * sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a region of %zu voxels", count);
    region_of(s->scene, origin, size);
    ost_status status = method_device_check(clEnqueueReadImage(s->device->cl.queue, s->bone, CL_TRUE, origin, size, 0,
                                                               0, voxels, 0, NULL, NULL),
                                            "clEnqueueReadImage", err);
    if (status == OST_OK)
        method_set_add_removed(set, s->scene, voxels);
    free(voxels);
    return status;
}

static void work(void *state, method_work *out)
{
    const texture *s = state;
    const bench_scene *event = &s->scene->event;
    *out = (method_work){.visited = (int64_t)method_box_count(&event->box),
                         .bone_bytes = ost_dims_count(event->bone.dims) * (int64_t)sizeof(int16_t),
                         .index_bytes = (int64_t)method_box_count(&event->box),
                         .tool_bytes = ost_dims_count(event->tool.geometry.dims)};
}
#endif

const method method_texture_cl = {
    .info = {.name = "texture-cl", .title = "3D textures of bone and tool, two kernels, on the device",
             .source = "thesis, 2.2: one 3D texture",
             .definition = METHODS_BONE_TO_TOOL, .device = true},
    .native = true,
    .per_bone_voxel = 2, .per_tool_voxel = 2,
#ifdef HAVE_OPENCL
    .open = open_texture, .close = close_texture, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
#endif
};
