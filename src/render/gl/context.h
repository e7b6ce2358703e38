/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A context of OpenGL without a display, of the thread that opens it; and what
 * a driver complains of, as an error.
 *
 *   EGL:  the platform without a surface (Mesa), each device that EGL lists
 *         (NVIDIA, Mesa); the first that is not software, else the first
 */
#ifndef OST_RENDER_GL_CONTEXT_H
#define OST_RENDER_GL_CONTEXT_H

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "render/gl/gl.h"

typedef struct ost_gl_context {
    EGLDisplay display;
    EGLContext context;
    int version;         /* ten times it, as far as it may be used */
    bool persistent;     /* buffers can stay mapped (4.4) */
    bool zero_to_one;    /* depth can be had as it is given (4.5) */
    ost_gl_info info;
    char complaint[256]; /* the driver's first, since the last check */
} ost_gl_context;

/* The struct must stay where it is: the driver's messages go into it. */
ost_status ost_gl_context_open(ost_gl_context *context, const ost_gl_options *options, ost_error *err);
void ost_gl_context_close(ost_gl_context *context); /* also of a zeroed one */

/* OST_OK when nothing went wrong since the last check; doing: "draws 3 things". */
ost_status ost_gl_context_check(ost_gl_context *context, const char *doing, ost_error *err);

#endif
