/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Transfers data and launches kernels. All stages use the queue only through these functions.
 *
 * Work groups.  Kernels accept ranges that are rounded up, have no barrier and do not use the number of their work
 * group, so the size of a work group affects only the speed.  The host always specifies the size, because some drivers
 * would choose groups of one item if a range is a prime number.
 */
#include "cl/cl.h"

#include <string.h>

enum { WORKGROUP_DEFAULT = 64 };

/* Returns true if each work item of the kernel takes a long time. Such a kernel is launched with groups of one item.
   With larger groups, some cores would be idle while another core processes a group of several items. */
static bool long_items(enum ost_cl_kernel kernel)
{
    return kernel == OST_CL_KERNEL_ost_remove_blocks || kernel == OST_CL_KERNEL_ost_chunk_scan_layers ||
           kernel == OST_CL_KERNEL_ost_chunk_store_layers || kernel == OST_CL_KERNEL_ost_chunk_load_rows ||
           kernel == OST_CL_KERNEL_ost_vox_tiles;
}

static const char *const kernel_names[] = {
#define OST_CL_KERNEL_TEXT(name, sets) #name,
    OST_CL_KERNELS(OST_CL_KERNEL_TEXT)
#undef OST_CL_KERNEL_TEXT
};

ost_status ost_cl_buffer_zero(cl_backend *b, size_t bytes, const char *what, cl_mem *out, ost_error *err)
{
    ost_status status = ost_cl_buffer(b, bytes, NULL, what, out, err);
    if (status == OST_OK)
        status = ost_cl_zero(b, *out, 0, bytes, err);
    if (status != OST_OK)
        ost_cl_buffer_free(b, out);
    return status;
}

static ost_status fill_zero(cl_backend *b, cl_mem buffer, size_t offset, size_t bytes, size_t unit, ost_error *err)
{
    const cl_ulong16 zeros = {{0}};
    if (bytes == 0)
        return OST_OK;
    cl_int code = b->cl->clEnqueueFillBuffer(b->queue, buffer, &zeros, unit, offset, bytes, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueFillBuffer", "");
}

/*
 * Sets a part of a buffer to zero. Uses the widest pattern of OpenCL, because drivers fill one pattern after the other.
 * The unaligned ends of the part are filled byte by byte.
 */
ost_status ost_cl_zero(cl_backend *b, cl_mem buffer, size_t offset, size_t bytes, ost_error *err)
{
    const size_t unit = sizeof(cl_ulong16), begin = (offset + unit - 1) / unit * unit,
                 end = (offset + bytes) / unit * unit;
    if (begin >= end)
        return fill_zero(b, buffer, offset, bytes, 1, err);
    ost_status status = fill_zero(b, buffer, offset, begin - offset, 1, err);
    if (status == OST_OK)
        status = fill_zero(b, buffer, begin, end - begin, unit, err);
    if (status == OST_OK)
        status = fill_zero(b, buffer, end, offset + bytes - end, 1, err);
    return status;
}

ost_status ost_cl_write(cl_backend *b, cl_mem buffer, size_t offset, size_t bytes, const void *data, ost_error *err)
{
    if (bytes == 0)
        return OST_OK;
    cl_int code = b->cl->clEnqueueWriteBuffer(b->queue, buffer, CL_TRUE, offset, bytes, data, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueWriteBuffer", "");
}

ost_status ost_cl_write_later(cl_backend *b, cl_mem buffer, size_t bytes, const void *data, ost_error *err)
{
    if (bytes == 0)
        return OST_OK;
    cl_int code = b->cl->clEnqueueWriteBuffer(b->queue, buffer, CL_FALSE, 0, bytes, data, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueWriteBuffer", "");
}

ost_status ost_cl_read(cl_backend *b, cl_mem buffer, size_t offset, size_t bytes, void *data, ost_error *err)
{
    if (bytes == 0)
        return OST_OK;
    cl_int code = b->cl->clEnqueueReadBuffer(b->queue, buffer, CL_TRUE, offset, bytes, data, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueReadBuffer", "");
}

ost_status ost_cl_read_later(cl_backend *b, cl_mem buffer, size_t offset, size_t bytes, void *data, ost_error *err)
{
    cl_int code = b->cl->clEnqueueReadBuffer(b->queue, buffer, CL_FALSE, offset, bytes, data, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueReadBuffer", "");
}

ost_status ost_cl_copy(cl_backend *b, cl_mem from, cl_mem to, size_t bytes, ost_error *err)
{
    if (bytes == 0)
        return OST_OK;
    cl_int code = b->cl->clEnqueueCopyBuffer(b->queue, from, to, 0, 0, bytes, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueCopyBuffer", "");
}

ost_status ost_cl_finish(cl_backend *b, ost_error *err)
{
    cl_int code = b->cl->clFinish(b->queue);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clFinish", "");
}

/*
 * Returns the size of a work group. This is the size that the user has requested or the default, limited to the
 * kernel's maximum. A default size is reduced to the size that the range needs.
 */
static size_t group_size(const cl_backend *b, enum ost_cl_kernel kernel, size_t range)
{
    size_t size = b->workgroup ? b->workgroup : long_items(kernel) ? 1 : WORKGROUP_DEFAULT;
    if (size > b->kernel_workgroup[kernel])
        size = b->kernel_workgroup[kernel];
    while (!b->workgroup && size > 1 && size / 2 >= range)
        size /= 2;
    return size ? size : 1;
}

ost_status ost_cl_launch(cl_backend *b, enum ost_cl_kernel kernel, size_t x, size_t y, size_t z, const ost_cl_arg *args,
                         unsigned count, ost_error *err)
{
    if (x == 0 || y == 0 || z == 0)
        return OST_OK;
    for (unsigned i = 0; i < count; i++) {
        cl_int code = b->cl->clSetKernelArg(b->kernel[kernel], i, args[i].size, args[i].value);
        if (code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clSetKernelArg", kernel_names[kernel]);
    }
    const size_t local[3] = {group_size(b, kernel, x), 1, 1};
    const size_t global[3] = {(x + local[0] - 1) / local[0] * local[0], y, z};
    cl_int code = b->cl->clEnqueueNDRangeKernel(b->queue, b->kernel[kernel], 3, NULL, global, local, 0, NULL, NULL);
    b->launched[kernel] += code == CL_SUCCESS;
    return code == CL_SUCCESS ? OST_OK
                              : ost_cl_fail(err, b->device.name, code, "clEnqueueNDRangeKernel", kernel_names[kernel]);
}
