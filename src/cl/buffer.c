/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Creates and releases buffers, with a pool of large buffers that were freed and can be reused for buffers of about the
 * same size.
 *
 * Buffers are reused because a new buffer takes time. A driver allocates a large buffer from the system, which maps the
 * buffer page by page at the first access. For a bone on a CPU, mapping took longer than filling the buffer. A buffer
 * may be returned to the pool while earlier commands still use it, because the queue is in order: these commands end
 * before the commands of the next owner begin.
 */
#include "cl/cl.h"

#include <stdio.h>

enum { LEAST = 1 << 20, MOST = 1 << 28 };

void ost_cl_buffer_free(cl_backend *b, cl_mem *buffer)
{
    if (*buffer)
        b->cl->clReleaseMemObject(*buffer);
    *buffer = NULL;
}

bool ost_cl_spare_clear(cl_backend *b)
{
    bool any = false;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        any = any || b->spare[i].buffer;
        ost_cl_buffer_free(b, &b->spare[i].buffer);
    }
    return any;
}

ost_status ost_cl_buffer(cl_backend *b, size_t bytes, const void *data, const char *what, cl_mem *out, ost_error *err)
{
    char text[80];
    snprintf(text, sizeof text, "%s, %zu bytes", what, bytes);
    /* A size above the limit is not passed to the driver, so that the error is the same with all drivers. */
    cl_int code = CL_INVALID_BUFFER_SIZE;
    *out = NULL;
    if (bytes <= b->device.max_buffer)
        *out = b->cl->clCreateBuffer(b->context, CL_MEM_READ_WRITE | (data && bytes ? CL_MEM_COPY_HOST_PTR : 0),
                                     bytes ? bytes : 1, data && bytes ? (void *)(uintptr_t)data : NULL, &code);
    if (*out && code == CL_SUCCESS)
        return OST_OK;
    *out = NULL;
    /* Releasing the buffers that are kept for reuse may free enough memory, so the call is repeated. */
    if (ost_cl_spare_clear(b))
        return ost_cl_buffer(b, bytes, data, what, out, err);
    return ost_cl_fail(err, b->device.name, code, "clCreateBuffer", text);
}

/* Returns the index of the smallest buffer in the pool that has at least `bytes` bytes and at most a quarter more.
   Returns -1 if there is no such buffer. */
static int find(const cl_backend *b, size_t bytes)
{
    int best = -1;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        const size_t has = b->spare[i].bytes;
        if (b->spare[i].buffer && has >= bytes && has - bytes <= bytes / 4 && (best < 0 || has < b->spare[best].bytes))
            best = i;
    }
    return best;
}

ost_status ost_cl_spare_take(cl_backend *b, size_t bytes, const char *what, cl_mem *out, size_t *reserved,
                             ost_error *err)
{
    const int i = bytes >= ost_cl_staging(b, LEAST) ? find(b, bytes) : -1;
    *reserved = bytes;
    if (i < 0)
        return ost_cl_buffer(b, bytes, NULL, what, out, err);
    b->entered[OST_CL_PATH_BUFFER_REUSED]++;
    *out = b->spare[i].buffer;
    *reserved = b->spare[i].bytes;
    b->spare[i].buffer = NULL;
    return OST_OK;
}

void ost_cl_spare_return(cl_backend *b, cl_mem *buffer, size_t reserved)
{
    size_t spare_bytes = reserved;
    int empty = -1;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        spare_bytes += b->spare[i].buffer ? b->spare[i].bytes : 0;
        empty = b->spare[i].buffer ? empty : i;
    }
    if (!*buffer || reserved < ost_cl_staging(b, LEAST) || spare_bytes > MOST || empty < 0) {
        ost_cl_buffer_free(b, buffer);
        return;
    }
    b->spare[empty].buffer = *buffer;
    b->spare[empty].bytes = reserved;
    *buffer = NULL;
}
