/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The textures into which a frame is drawn.
 *
 *   G-buffer   depth; colour, face and depth along the forward axis, or normal and colour as in the thesis
 *   tiles      the farthest depth in each tile of 8 x 8 pixels of the G-buffer (hide.h)
 *   picture    colour, with the face in the last channel; depth along the forward axis
 *
 * Row 0 is the picture's top row, also in shaders.
 */
#ifndef OST_RENDER_GL_TARGET_H
#define OST_RENDER_GL_TARGET_H

#include "render/gl/context.h"

typedef struct ost_gl_targets {
    int width, height;   /* 0 if the textures do not exist yet */
    ost_gl_target kind;  /* format of the G-buffer */
    /* `gbuffer` is 0 for OST_GL_FORWARD, which draws into the picture without a G-buffer */
    GLuint gbuffer, gbuffer_depth, gbuffer_0, gbuffer_1;
    GLuint tiles, tiles_depth; /* framebuffer and texture of the tiles' depths; only with OST_GL_COMPACT */
    int across, down;    /* size of the tiles' texture, in tiles */
    float *farthest;     /* owned; farthest depth of each tile */
    float *depths;       /* owned; depth of each pixel; NULL before the first use */
    GLuint picture, picture_depth, picture_colour;
} ost_gl_targets;

/* Creates a texture without contents, whose texels are read without interpolation. */
GLuint ost_gl_texture(GLenum internal, GLenum format, GLenum type, int width, int height);
ost_status ost_gl_targets_make(ost_gl_context *context, ost_gl_targets *targets, int width, int height,
                               ost_gl_target kind, ost_error *err);
void ost_gl_targets_free(ost_gl_targets *targets);
/* Frees only memory, without calling OpenGL. */
void ost_gl_targets_abandon(ost_gl_targets *targets);

#endif
