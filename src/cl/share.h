/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bone's occupancy words in a buffer of OpenGL (cl_khr_gl_sharing): what is
 * drawn is what the kernels write, and nothing is copied.
 *
 *   open with the GL context --> backend
 *   bone, GL buffer ----share----> the words move there, once
 *                                  each call that touches them:
 *                                  acquire -> kernels -> release, finish
 *   ----unshare---->               the words move back
 *
 * Where the platform cannot share, ost_cl_words_read copies the chunks that an
 * event's report names.  Either way word w of chunk c is word
 * slot * n^3 / 32 + w of the pool, slot = ost_cl_words_slot(c).
 *
 * Who draws finishes (glFinish, or a fence) before it calls anything that
 * touches the bone; what has been called is done for GL when it returns.  An
 * upload may need a larger pool: it unshares first, and the caller shares anew.
 *
 * Never run on a platform that can do it: none was at hand.  The calls and
 * their order are held by tests/cl/test_cl_share.c on a platform that is made
 * to say that it can.
 */
#ifndef OST_CL_SHARE_H
#define OST_CL_SHARE_H

#include "cl/objects.h"

typedef enum ost_cl_gl_kind { OST_CL_GL_GLX, OST_CL_GL_EGL, OST_CL_GL_WGL } ost_cl_gl_kind;

/* The GL context that draws; current in the thread that opens the backend. */
typedef struct ost_cl_gl {
    ost_cl_gl_kind kind;
    void *context; /* GLXContext, EGLContext, HGLRC */
    void *display; /* Display *, EGLDisplay, HDC */
} ost_cl_gl;

enum { OST_CL_GL_PROPERTIES = 7 };
/* For clCreateContext; gl may be NULL. */
void ost_cl_gl_properties(const ost_cl_gl *gl, cl_platform_id platform, cl_context_properties out[OST_CL_GL_PROPERTIES]);
/* Whether the device says that it can share. */
bool ost_cl_gl_said(const ost_cl_api *cl, const ost_cl_device *device);

/* ost_cl_open_with for devices that share with that context; OST_ERR_UNAVAILABLE when none can. */
ost_status ost_cl_open_shared(const ost_cl_api *cl, const char *options, const ost_cl_gl *gl, ost_backend **out, ost_error *err);

/* Bytes that a GL buffer needs for the bone's words as it is now. */
size_t ost_cl_words_bytes(const ost_bone *bone);
/* On an error the bone is as before. bytes is the GL buffer's size. */
ost_status ost_cl_words_share(ost_bone *bone, unsigned gl_buffer, size_t bytes, ost_error *err);
ost_status ost_cl_words_unshare(ost_bone *bone, ost_error *err);
bool ost_cl_words_shared(const ost_bone *bone);

/* OST_CL_NONE when the chunk has no active voxel. */
uint32_t ost_cl_words_slot(const ost_bone *bone, int32_t chunk);
/* The words of these chunks one after the other, zeros for one without a slot; waits once. */
ost_status ost_cl_words_read(const ost_bone *bone, const int32_t *chunks, size_t count, uint32_t *words, ost_error *err);

/* Slots of the table for bones that may be shared: as the functions of the same names without "held". */
ost_status ost_cl_held_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_held_remove(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
ost_status ost_cl_held_collide(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);

#endif
