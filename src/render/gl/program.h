/* SPDX-License-Identifier: Apache-2.0 */
/* Compiles programs of two shaders. Each shader consists of macro definitions followed by several parts. */
#ifndef OST_RENDER_GL_PROGRAM_H
#define OST_RENDER_GL_PROGRAM_H

#include "render/gl/context.h"

typedef struct ost_gl_source {
    const char *name; /* for messages */
    const char *const *parts;
    size_t count;
} ost_gl_source;

enum { OST_GL_EYE = 0 }; /* binding of the uniform block that shaders/eye.glsl declares */

/*
 * Compiles and links a program. `defines` consists of #define lines. `samplers` and `inputs` are lists that end with
 * NULL. In list order, the samplers get the texture units 0, 1, ..., and the inputs get the locations 0, 1, ...
 */
ost_status ost_gl_program_make(ost_gl_context *context, const ost_gl_source *vertex, const ost_gl_source *fragment,
                               const char *defines, const char *const *inputs, const char *const *samplers, GLuint *out,
                               ost_error *err);

#endif
