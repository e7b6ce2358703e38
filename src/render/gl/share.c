/* SPDX-License-Identifier: Apache-2.0 */
/* Shares the renderer's context with a library that displays the pictures, for example OpenXR. */
#include "render/gl/insides.h"

ost_gl_egl ost_gl_egl_get(const ost_gl *gl)
{
    return (ost_gl_egl){gl->context.display, gl->context.config, gl->context.context};
}

ost_status ost_gl_do(ost_gl *gl, ost_gl_function *function, void *user, ost_error *err)
{
    return ost_gl_worker_do(gl->worker, function, user, err);
}

typedef struct copying {
    ost_gl *gl;
    GLuint texture;
} copying;

/* Row 0 is the top row of a picture, but the bottom row of a texture. */
static ost_status copy_here(void *user, ost_error *err)
{
    const copying *c = user;
    const ost_gl_targets *t = &c->gl->targets;
    GLuint frame;
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frame);
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, c->texture, 0);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, t->picture);
    glDisable(GL_SCISSOR_TEST);
    /* The picture contains display values, which are copied unchanged even to an sRGB texture. */
    glDisable(GL_FRAMEBUFFER_SRGB);
    glBlitFramebuffer(0, 0, t->width, t->height, 0, t->height, t->width, 0, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(1, &frame);
    return ost_gl_context_check(&c->gl->context, "copies a picture", err);
}

ost_status ost_gl_copy(ost_gl *gl, unsigned texture, ost_error *err)
{
    return ost_gl_worker_do(gl->worker, copy_here, &(copying){gl, texture}, err);
}
