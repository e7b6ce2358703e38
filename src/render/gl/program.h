/* SPDX-License-Identifier: Apache-2.0 */
/* A program of two shaders, each made of several parts, with macros that are defined before them. */
#ifndef OST_RENDER_GL_PROGRAM_H
#define OST_RENDER_GL_PROGRAM_H

#include "render/gl/context.h"

typedef struct ost_gl_source {
    const char *name; /* for messages */
    const char *const *parts;
    size_t count;
} ost_gl_source;

enum { OST_GL_EYE = 0 }; /* the uniform block's binding */

/*
 * Compiles and links a program.  defines: lines of #define.  The samplers named
 * up to NULL get units 0, 1, ...; the inputs get locations 0, 1, ...
 */
ost_status ost_gl_program_make(ost_gl_context *context, const ost_gl_source *vertex, const ost_gl_source *fragment,
                               const char *defines, const char *const *inputs, const char *const *samplers, GLuint *out,
                               ost_error *err);

#endif
