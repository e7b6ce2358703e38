/* SPDX-License-Identifier: Apache-2.0 */
#include "window/shown.h"

#include <stddef.h>

#include "window/embedded.h"

static GLuint shader(GLenum kind, const char *text)
{
    const GLuint s = glCreateShader(kind);
    const char *parts[] = {"#version 330 core\n", text};
    GLint compiled = 0;
    glShaderSource(s, 2, parts, NULL);
    glCompileShader(s);
    glGetShaderiv(s, GL_COMPILE_STATUS, &compiled);
    if (compiled)
        return s;
    glDeleteShader(s);
    return 0;
}

bool ost_shown_make(ost_shown *shown)
{
    const GLuint v = shader(GL_VERTEX_SHADER, ost_window_picture_vert[0]),
                 f = shader(GL_FRAGMENT_SHADER, ost_window_picture_frag[0]);
    GLint linked = 0;
    *shown = (ost_shown){0};
    if (v && f) {
        shown->program = glCreateProgram();
        glAttachShader(shown->program, v);
        glAttachShader(shown->program, f);
        glLinkProgram(shown->program);
        glGetProgramiv(shown->program, GL_LINK_STATUS, &linked);
    }
    if (v)
        glDeleteShader(v);
    if (f)
        glDeleteShader(f);
    glGenVertexArrays(1, &shown->nothing);
    glGenTextures(1, &shown->texture);
    glBindTexture(GL_TEXTURE_2D, shown->texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return linked != 0;
}

void ost_shown_free(ost_shown *shown)
{
    if (shown->program)
        glDeleteProgram(shown->program);
    if (shown->texture)
        glDeleteTextures(1, &shown->texture);
    if (shown->nothing)
        glDeleteVertexArrays(1, &shown->nothing);
    *shown = (ost_shown){0};
}

bool ost_shown_draw(ost_shown *shown, const uint32_t *pixels, int stride, int width, int height, int frame_width,
                    int frame_height)
{
    /* Another module may have changed the state of this context. */
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glActiveTexture(GL_TEXTURE0);
    glViewport(0, 0, frame_width, frame_height);
    glBindTexture(GL_TEXTURE_2D, shown->texture);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, stride);
    if (width != shown->width || height != shown->height) {
        for (int old = 0; old < 16 && glGetError() != GL_NO_ERROR; old++)
            ; /* limited, because a lost context may report errors forever */
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
        shown->width = shown->height = 0;
        if (glGetError() != GL_NO_ERROR)
            return false;
        shown->width = width;
        shown->height = height;
    } else {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    }
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glUseProgram(shown->program);
    glBindVertexArray(shown->nothing);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return true;
}
