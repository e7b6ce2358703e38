/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Occupancy words in an OpenGL buffer.  Of the function table's slots only upload,
 * remove and collide access the words; downloads and digests read densities
 * alone, so they need not acquire the buffer.
 */
#include "cl/share.h"

#include <stdlib.h>
#include <string.h>

void ost_cl_gl_properties(const ost_cl_gl *gl, cl_platform_id platform, cl_context_properties out[OST_CL_GL_PROPERTIES])
{
    static const cl_context_properties displays[] = {CL_GLX_DISPLAY_KHR, CL_EGL_DISPLAY_KHR, CL_WGL_HDC_KHR};
    int n = 0;
    if (gl) {
        out[n++] = CL_GL_CONTEXT_KHR;
        out[n++] = (cl_context_properties)gl->context;
        out[n++] = displays[gl->kind];
        out[n++] = (cl_context_properties)gl->display;
    }
    out[n++] = CL_CONTEXT_PLATFORM;
    out[n++] = (cl_context_properties)platform;
    out[n] = 0;
}

bool ost_cl_gl_said(const ost_cl_api *cl, const ost_cl_device *device)
{
    static const char name[] = "cl_khr_gl_sharing";
    size_t size = 0;
    if (cl->clGetDeviceInfo(device->id, CL_DEVICE_EXTENSIONS, 0, NULL, &size) != CL_SUCCESS || size == 0 || size > 1 << 20)
        return false;
    char *words = calloc(1, size + 2);
    bool found = false;
    /* The name must be a complete word of the list, with a blank or an end on both sides. */
    if (words && cl->clGetDeviceInfo(device->id, CL_DEVICE_EXTENSIONS, size, words, NULL) == CL_SUCCESS)
        for (const char *p = words; !found && (p = strstr(p, name)); p += sizeof name - 1)
            found = (p == words || p[-1] == ' ') && strchr(" ", p[sizeof name - 1]);
    free(words);
    return found;
}

static cl_backend *backend_of(const cl_bone *bone)
{
    return (cl_backend *)bone->base.backend;
}

static size_t slot_bytes(const cl_bone *bone)
{
    return bone->chunk_voxels / 8;
}

size_t ost_cl_words_bytes(const ost_bone *base)
{
    const cl_bone *bone = (const cl_bone *)base;
    return bone->capacity * slot_bytes(bone);
}

bool ost_cl_words_shared(const ost_bone *bone)
{
    return ((const cl_bone *)bone)->words_shared;
}

uint32_t ost_cl_words_slot(const ost_bone *base, int32_t chunk)
{
    const cl_bone *bone = (const cl_bone *)base;
    return chunk < 0 || (size_t)chunk >= bone->chunks ? OST_CL_NONE : bone->slot[chunk];
}

/* --------------------------------------------------------------- holding */

static ost_status acquire(cl_backend *b, cl_mem words, ost_error *err)
{
    const cl_int code = b->cl->clEnqueueAcquireGLObjects(b->queue, 1, &words, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueAcquireGLObjects", "");
}

/* Releases the buffer to OpenGL and waits, so that OpenGL may draw afterwards. */
static ost_status release(cl_backend *b, cl_mem words, ost_error *err)
{
    const cl_int code = b->cl->clEnqueueReleaseGLObjects(b->queue, 1, &words, 0, NULL, NULL);
    if (code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clEnqueueReleaseGLObjects", "");
    return ost_cl_finish(b, err);
}

/* Copies bytes from one pool to the other; both have at least this size. gl is the one of the two that OpenGL
   shares. */
static ost_status move(cl_backend *b, cl_mem from, cl_mem to, cl_mem gl, size_t bytes, ost_error *err)
{
    ost_status status = acquire(b, gl, err);
    if (status != OST_OK)
        return status;
    status = ost_cl_copy(b, from, to, bytes, err);
    const ost_status released = release(b, gl, status == OST_OK ? err : NULL);
    return status == OST_OK ? released : status;
}

ost_status ost_cl_words_share(ost_bone *base, unsigned gl_buffer, size_t bytes, ost_error *err)
{
    cl_bone *bone = (cl_bone *)base;
    cl_backend *b = backend_of(bone);
    const size_t needed = ost_cl_words_bytes(base);
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status != OST_OK)
        return status;
    if (!b->gl)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL device '%.120s' was not opened with a context of OpenGL", b->device.name);
    if (bone->words_shared)
        return ost_fail(err, OST_ERR_USAGE, "the bone's words are in a buffer of OpenGL already");
    if (bytes < needed || needed == 0)
        return ost_fail(err, OST_ERR_RANGE, "a buffer of OpenGL of %zu bytes; the bone has %zu", bytes, needed);
    cl_int code = CL_SUCCESS;
    cl_mem words = b->cl->clCreateFromGLBuffer(b->context, CL_MEM_READ_WRITE, gl_buffer, &code);
    if (!words || code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clCreateFromGLBuffer", "");
    status = move(b, bone->words, words, words, needed, err);
    if (status != OST_OK) {
        ost_cl_buffer_free(b, &words);
        return status;
    }
    ost_cl_buffer_free(b, &bone->words);
    bone->words = words;
    bone->words_shared = true;
    return OST_OK;
}

ost_status ost_cl_words_unshare(ost_bone *base, ost_error *err)
{
    cl_bone *bone = (cl_bone *)base;
    cl_backend *b = backend_of(bone);
    cl_mem words = NULL;
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status != OST_OK || !bone->words_shared)
        return status;
    status = ost_cl_buffer(b, ost_cl_words_bytes(base), NULL, "occupancy of a bone", &words, err);
    if (status == OST_OK)
        status = move(b, bone->words, words, bone->words, ost_cl_words_bytes(base), err);
    if (status != OST_OK) {
        ost_cl_buffer_free(b, &words);
        return status;
    }
    ost_cl_buffer_free(b, &bone->words);
    bone->words = words;
    bone->words_shared = false;
    return OST_OK;
}

/* ------------------------------------------------------------ the slots */

ost_status ost_cl_held_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    ost_status status = ost_cl_words_unshare(bone, err);
    return status == OST_OK ? ost_cl_bone_upload(bone, z0, count, voxels, err) : status;
}

/* Runs the event between acquiring and releasing the words; they are released also if the event fails. */
static ost_status held_event(cl_bone *bone, const ost_tool *tool, const ost_event *event, bool apply, ost_report *report, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    ost_status status = acquire(b, bone->words, err);
    if (status != OST_OK)
        return status;
    status = apply ? ost_cl_remove(&bone->base, tool, event, report, err) : ost_cl_collide(&bone->base, tool, event, report, err);
    const ost_status released = release(b, bone->words, status == OST_OK ? err : NULL);
    if (status == OST_OK && released != OST_OK && apply)
        bone->lost = true; /* the event was performed, but its caller receives an error */
    return status == OST_OK ? released : status;
}

ost_status ost_cl_held_remove(ost_bone *base, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err)
{
    cl_bone *bone = (cl_bone *)base;
    if (!bone->words_shared || bone->lost)
        return ost_cl_remove(base, tool, event, report, err);
    return held_event(bone, tool, event, true, report, err);
}

ost_status ost_cl_held_collide(const ost_bone *base, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err)
{
    cl_bone *bone = (cl_bone *)(uintptr_t)base;
    if (!bone->words_shared || bone->lost)
        return ost_cl_collide(base, tool, event, report, err);
    return held_event(bone, tool, event, false, report, err);
}

/* ------------------------------------------------------- without sharing */

ost_status ost_cl_words_read(const ost_bone *base, const int32_t *chunks, size_t count, uint32_t *words, ost_error *err)
{
    const cl_bone *bone = (const cl_bone *)base;
    cl_backend *b = backend_of(bone);
    const size_t bytes = slot_bytes(bone);
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status == OST_OK && bone->words_shared)
        status = ost_fail(err, OST_ERR_USAGE, "the bone's words are in a buffer of OpenGL: they need no copy");
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const uint32_t slot = ost_cl_words_slot(base, chunks[i]);
        void *to = words + i * (bytes / sizeof *words);
        cl_int code = CL_SUCCESS;
        if (slot == OST_CL_NONE)
            memset(to, 0, bytes);
        else
            code = b->cl->clEnqueueReadBuffer(b->queue, bone->words, CL_FALSE, slot * bytes, bytes, to, 0, NULL, NULL);
        if (code != CL_SUCCESS)
            status = ost_cl_fail(err, b->device.name, code, "clEnqueueReadBuffer", "");
    }
    /* Reads in progress must end before the call returns, since they write to the caller's memory. */
    const ost_status finished = ost_cl_finish(b, status == OST_OK ? err : NULL);
    return status == OST_OK ? finished : status;
}
