/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/program.h"

#include <stdio.h>
#include <string.h>

enum { PARTS = 8, LOG = 400 };

/* The keyword `precise` was introduced in OpenGL 4.0 and is available as an extension to 3.3. */
static const char new_head[] = "#version 400 core\n#define PRECISE precise\n";
static const char old_head[] = "#version 330 core\n"
                               "#ifdef GL_ARB_gpu_shader5\n"
                               "#extension GL_ARB_gpu_shader5 : enable\n"
                               "#define PRECISE precise\n"
                               "#else\n"
                               "#define PRECISE\n"
                               "#endif\n";

/* Truncates a log to its first line. */
static void one_line(char *log)
{
    log[strcspn(log, "\r\n")] = '\0';
}

static ost_status compile(ost_gl_context *c, GLenum kind, const ost_gl_source *source, const char *defines, GLuint *out,
                          ost_error *err)
{
    const char *text[PARTS + 2] = {c->version >= 40 ? new_head : old_head, defines};
    GLint compiled = 0;
    char log[LOG] = "";
    for (size_t i = 0; i < source->count && i < PARTS; i++)
        text[i + 2] = source->parts[i];
    *out = glCreateShader(kind);
    if (!*out)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL (%s) cannot create a shader", c->info.driver);
    glShaderSource(*out, (GLsizei)source->count + 2, text, NULL);
    glCompileShader(*out);
    glGetShaderiv(*out, GL_COMPILE_STATUS, &compiled);
    if (compiled)
        return OST_OK;
    glGetShaderInfoLog(*out, sizeof log, NULL, log);
    one_line(log);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL (%s) cannot compile %s: %s", c->info.driver, source->name, log);
}

static ost_status link(ost_gl_context *c, GLuint program, const char *name, ost_error *err)
{
    GLint linked = 0;
    char log[LOG] = "";
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked)
        return OST_OK;
    glGetProgramInfoLog(program, sizeof log, NULL, log);
    one_line(log);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL (%s) cannot link %s: %s", c->info.driver, name, log);
}

ost_status ost_gl_program_make(ost_gl_context *c, const ost_gl_source *vertex, const ost_gl_source *fragment,
                               const char *defines, const char *const *inputs, const char *const *samplers, GLuint *out,
                               ost_error *err)
{
    GLuint v = 0, f = 0;
    *out = 0;
    ost_status status = compile(c, GL_VERTEX_SHADER, vertex, defines, &v, err);
    if (status == OST_OK)
        status = compile(c, GL_FRAGMENT_SHADER, fragment, defines, &f, err);
    if (status == OST_OK && !(*out = glCreateProgram()))
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL (%s) cannot create a program", c->info.driver);
    if (status == OST_OK) {
        glAttachShader(*out, v);
        glAttachShader(*out, f);
        for (GLuint i = 0; inputs && inputs[i]; i++)
            glBindAttribLocation(*out, i, inputs[i]);
        glBindFragDataLocation(*out, 0, "kept");
        glBindFragDataLocation(*out, 1, "kept_1");
        status = link(c, *out, fragment->name, err);
    }
    glDeleteShader(v);
    glDeleteShader(f);
    if (status != OST_OK) {
        glDeleteProgram(*out);
        *out = 0;
        return status;
    }
    const GLuint eye = glGetUniformBlockIndex(*out, "Eye");
    if (eye != GL_INVALID_INDEX)
        glUniformBlockBinding(*out, eye, OST_GL_EYE);
    glUseProgram(*out);
    for (GLint i = 0; samplers[i]; i++) {
        const GLint at = glGetUniformLocation(*out, samplers[i]);
        if (at >= 0)
            glUniform1i(at, i);
    }
    return OST_OK;
}
