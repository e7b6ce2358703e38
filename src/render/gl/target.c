/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/target.h"

#include <stdlib.h>

#include "render/points/splat.h"

GLuint ost_gl_texture(GLenum internal, GLenum format, GLenum type, int width, int height)
{
    GLuint t = 0;
    glGenTextures(1, &t);
    glBindTexture(GL_TEXTURE_2D, t);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, width, height, 0, format, type, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    return t;
}

static GLuint depth_texture(int width, int height)
{
    return ost_gl_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
}

/* Creates a framebuffer. `colour_1` is 0 if there is only one colour texture. */
static GLuint framebuffer(GLuint depth, GLuint colour, GLuint colour_1, GLenum *complete)
{
    static const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    GLuint f = 0;
    glGenFramebuffers(1, &f);
    glBindFramebuffer(GL_FRAMEBUFFER, f);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour, 0);
    if (colour_1)
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, colour_1, 0);
    glDrawBuffers(colour_1 ? 2 : 1, both);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    *complete = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    return f;
}

void ost_gl_targets_free(ost_gl_targets *t)
{
    const GLuint frames[3] = {t->gbuffer, t->tiles, t->picture};
    const GLuint textures[6] = {t->gbuffer_depth, t->gbuffer_0,     t->gbuffer_1,
                                t->tiles_depth,   t->picture_depth, t->picture_colour};
    if (t->width) {
        glDeleteFramebuffers(3, frames);
        glDeleteTextures(6, textures);
    }
    ost_gl_targets_abandon(t);
}

void ost_gl_targets_abandon(ost_gl_targets *t)
{
    free(t->farthest);
    free(t->depths);
    *t = (ost_gl_targets){0};
}

ost_status ost_gl_targets_make(ost_gl_context *context, ost_gl_targets *t, int width, int height, ost_gl_target kind,
                               ost_error *err)
{
    GLenum gbuffer = GL_FRAMEBUFFER_COMPLETE, tiles = GL_FRAMEBUFFER_COMPLETE, picture;
    GLint largest = 0;
    if (t->width == width && t->height == height && t->kind == kind)
        return OST_OK;
    ost_gl_targets_free(t);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (width > largest || height > largest)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; OpenGL (%s) draws up to %d a side", width,
                        height, context->info.driver, (int)largest);
    t->width = width;
    t->height = height;
    t->kind = kind;
    t->picture_depth = depth_texture(width, height);
    t->picture_colour = ost_gl_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
    t->picture = framebuffer(t->picture_depth, t->picture_colour, 0, &picture);
    if (kind != OST_GL_FORWARD) {
        t->gbuffer_depth = depth_texture(width, height);
        if (kind == OST_GL_COMPACT) {
            t->gbuffer_0 = ost_gl_texture(GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, width, height);
            t->across = (width + OST_TILE - 1) / OST_TILE;
            t->down = (height + OST_TILE - 1) / OST_TILE;
            t->tiles_depth = ost_gl_texture(GL_R32F, GL_RED, GL_FLOAT, t->across, t->down);
            t->tiles = framebuffer(0, t->tiles_depth, 0, &tiles);
            t->farthest = malloc((size_t)t->across * (size_t)t->down * sizeof *t->farthest);
        } else {
            const GLenum internal = kind == OST_GL_WIDE ? GL_RGBA32F : GL_RGBA8,
                         type = kind == OST_GL_WIDE ? GL_FLOAT : GL_UNSIGNED_BYTE;
            t->gbuffer_0 = ost_gl_texture(internal, GL_RGBA, type, width, height);
            t->gbuffer_1 = ost_gl_texture(internal, GL_RGBA, type, width, height);
        }
        t->gbuffer = framebuffer(t->gbuffer_depth, t->gbuffer_0, t->gbuffer_1, &gbuffer);
    }
    ost_status status = ost_gl_context_check(context, "makes a frame's buffers", err);
    const GLenum wrong = gbuffer != GL_FRAMEBUFFER_COMPLETE ? gbuffer
                         : tiles != GL_FRAMEBUFFER_COMPLETE ? tiles
                                                            : picture;
    if (status == OST_OK && wrong != GL_FRAMEBUFFER_COMPLETE)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL (%s) cannot draw into a framebuffer of this kind (0x%x)",
                          context->info.driver, wrong);
    if (status == OST_OK && kind == OST_GL_COMPACT && !t->farthest)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a frame of %d x %d pixels", width, height);
    if (status != OST_OK)
        ost_gl_targets_free(t);
    return status;
}
