/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens an OpenGL context without a display, or adopts the context that is current on the calling thread. The context
 * belongs to the thread that opens it. Messages from the driver are reported as errors, except in an adopted context.
 *
 * EGL offers several ways to open a context without a display: the platform without a surface (Mesa), and each device
 * that EGL lists (NVIDIA, Mesa). The first one with a hardware renderer is used; if there is none, the first one that
 * works is used.
 */
#ifndef OST_RENDER_GL_CONTEXT_H
#define OST_RENDER_GL_CONTEXT_H

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "render/gl/gl.h"

typedef struct ost_gl_context {
    EGLDisplay display;
    EGLContext context;
    EGLConfig config;
    int version;         /* version of the context, times ten; not greater than the version in the options */
    bool persistent;     /* true if buffers can stay mapped (OpenGL 4.4) */
    /* true if clip-space depth can range from 0 to 1 (OpenGL 4.5); depths are then stored without rounding */
    bool zero_to_one;
    ost_gl_info info;
    char complaint[256]; /* the driver's first message since the last check */
} ost_gl_context;

/* Opens a context. The driver writes messages to *out, so the struct must not be moved or copied afterwards. */
ost_status ost_gl_context_open(ost_gl_context *context, const ost_gl_options *options, ost_error *err);
void ost_gl_context_close(ost_gl_context *context); /* accepts a zero-initialized context */

/* Returns OST_OK if no error has occurred since the last check. `doing` describes the current action in messages,
   for example "draws 3 things". */
ost_status ost_gl_context_check(ost_gl_context *context, const char *doing, ost_error *err);

#endif
