/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The code that the tool-to-bone methods on an OpenCL device share. The bone is one buffer, and the points are a sparse
 * buffer of short4. The files yau.c, zheng.c and reza.c contain the kernels and their launches.
 *
 * A kernel has these arguments, in this order: the bone, the points, the map's base and fraction, its anchor, its steps
 * to the bone's x, y and z, the bone's dims, lo and hi of the box, the first point, and the number of points. The
 * kernel of reza.c also has the blocks as its last argument.
 */
#ifndef OST_REPRODUCTION_METHODS_POINTS_CL_H
#define OST_REPRODUCTION_METHODS_POINTS_CL_H

#include "reproduction/methods/device.h"
#include "reproduction/methods/points.h"

#ifdef HAVE_OPENCL

/* The OpenCL C code that precedes each kernel: the kernel's arguments, and the functions that find and remove the
   voxel that contains a point. */
#define POINTS_CL_SOURCE                                                                                               \
    "#define ARGUMENTS __global short *bone, __global const short4 *points, int4 base, int4 anchor, \\\n"              \
    "    int4 to_x, int4 to_y, int4 to_z, int4 dims, int4 lo, int4 hi, int first, int count\n"                         \
    "#define MAP base, anchor, to_x, to_y, to_z\n"                                                                     \
    "int4 voxel_of(int4 e, int4 base, int4 anchor, int4 to_x, int4 to_y, int4 to_z)\n"                                 \
    "{\n"                                                                                                              \
    "    const int f = base.w;\n"                                                                                      \
    "    const int ux = base.x + e.x * to_x.x + e.y * to_x.y + e.z * to_x.z;\n"                                        \
    "    const int uy = base.y + e.x * to_y.x + e.y * to_y.y + e.z * to_y.z;\n"                                        \
    "    const int uz = base.z + e.x * to_z.x + e.y * to_z.y + e.z * to_z.z;\n"                                        \
    "    return (int4)(anchor.x + (ux >> f), anchor.y + (uy >> f), anchor.z + (uz >> f), 0);\n"                        \
    "}\n"                                                                                                              \
    "void clear_voxel(__global short *bone, int4 v, int4 dims)\n"                                                      \
    "{\n"                                                                                                              \
    "    const uint at = (uint)v.x + (uint)dims.x * ((uint)v.y + (uint)dims.y * (uint)v.z);\n"                         \
    "    if (bone[at] != 0)\n"                                                                                         \
    "        bone[at] = 0;\n"                                                                                          \
    "}\n"                                                                                                              \
    "bool in_box(int4 v, int4 lo, int4 hi)\n"                                                                          \
    "{\n"                                                                                                              \
    "    return v.x >= lo.x && v.y >= lo.y && v.z >= lo.z && v.x < hi.x && v.y < hi.y && v.z < hi.z;\n"                \
    "}\n"

typedef struct points_cl {
    const methods_scene *scene;
    struct method_device *device; /* borrowed */
    cl_program program;
    cl_kernel kernel;
    cl_mem bone, buffer, blocks; /* `blocks` has eight ints per block: first, count, lo, hi */
    method_points points;
    int64_t visited;
} points_cl;

ost_status points_cl_open(const methods_scene *scene, const method_setup *setup, int block, const char *source,
                          const char *kernel, points_cl **out, ost_error *err);
void points_cl_close(void *state);
ost_status points_cl_restore(void *state, ost_error *err);
ost_status points_cl_result(void *state, method_set *set, ost_error *err);
void points_cl_work(void *state, method_work *out);

/* Returns the number of work items for `count` points, a multiple of 64. */
static inline size_t points_cl_items(int32_t count)
{
    return ((size_t)count + 63) / 64 * 64;
}

/* Runs the kernel on the points [first, first + count) for the box, and waits for its end. The kernel has `items` work
   items in groups of `group`; if `group` is 0, the driver chooses the size of a group. */
ost_status points_cl_run(points_cl *s, const ost_voxel_box *box, int32_t first, int32_t count, size_t items,
                         size_t group, ost_error *err);

#endif
#endif
