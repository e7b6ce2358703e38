/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bone's occupancy words in an OpenGL buffer (cl_khr_gl_sharing): OpenGL draws
 * the memory that the kernels write, without a copy.
 *
 *   open with the GL context --> backend
 *   bone, GL buffer ----share----> the words are moved there, once
 *                                  each call that accesses them:
 *                                  acquire -> kernels -> release, finish
 *   ----unshare---->               the words are moved back
 *
 * Where the platform cannot share, ost_cl_words_read copies the chunks that an
 * event's report names.  In both cases word w of chunk c is word
 * slot * n^3 / 32 + w of the pool, with slot = ost_cl_words_slot(c).
 *
 * The thread that draws must finish (glFinish, or a fence) before it calls any
 * function that accesses the bone.  When such a function returns, its work is
 * finished and visible to OpenGL.  An upload may need a larger pool: it unshares
 * the words first, and the caller must share them again.
 *
 * This code has never run on a platform with the extension, since none was
 * available.  tests/cl/test_cl_share.c checks the calls and their order with a
 * platform that a shim makes report the extension.
 */
#ifndef OST_CL_SHARE_H
#define OST_CL_SHARE_H

#include "cl/objects.h"

typedef enum ost_cl_gl_kind { OST_CL_GL_GLX, OST_CL_GL_EGL, OST_CL_GL_WGL } ost_cl_gl_kind;

/* The OpenGL context that draws; it is current in the thread that opens the backend. */
typedef struct ost_cl_gl {
    ost_cl_gl_kind kind;
    void *context; /* GLXContext, EGLContext, HGLRC */
    void *display; /* Display *, EGLDisplay, HDC */
} ost_cl_gl;

enum { OST_CL_GL_PROPERTIES = 7 };
/* Fills the properties for clCreateContext; gl may be NULL. */
void ost_cl_gl_properties(const ost_cl_gl *gl, cl_platform_id platform, cl_context_properties out[OST_CL_GL_PROPERTIES]);
/* Returns true if the device reports that it can share. */
bool ost_cl_gl_said(const ost_cl_api *cl, const ost_cl_device *device);

/* The same as ost_cl_open_with, for devices that share with that context. Returns OST_ERR_UNAVAILABLE if none can. */
ost_status ost_cl_open_shared(const ost_cl_api *cl, const char *options, const ost_cl_gl *gl, ost_backend **out, ost_error *err);

/* Returns the size in bytes that an OpenGL buffer needs for the bone's words at present. */
size_t ost_cl_words_bytes(const ost_bone *bone);
/* Moves the bone's words into an OpenGL buffer; bytes is its size. On an error the bone is unchanged. */
ost_status ost_cl_words_share(ost_bone *bone, unsigned gl_buffer, size_t bytes, ost_error *err);
ost_status ost_cl_words_unshare(ost_bone *bone, ost_error *err);
bool ost_cl_words_shared(const ost_bone *bone);

/* Returns the chunk's slot, or OST_CL_NONE if the chunk has no active voxel. */
uint32_t ost_cl_words_slot(const ost_bone *bone, int32_t chunk);
/* Reads the words of these chunks one after the other, zeros for a chunk without a slot. Waits once for all of them. */
ost_status ost_cl_words_read(const ost_bone *bone, const int32_t *chunks, size_t count, uint32_t *words, ost_error *err);

/* Slots of the function table for bones that may be shared. They do the same as the functions of these names without
   "held", and acquire and release shared words (upload unshares them). */
ost_status ost_cl_held_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_held_remove(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
ost_status ost_cl_held_collide(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);

#endif
