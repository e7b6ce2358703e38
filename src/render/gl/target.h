/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is drawn into.
 *
 *   G-buffer   depth; colour, face and depth along forward, or normal and colour as the thesis has it
 *   tiles      of 8 x 8 pixels of the G-buffer the farthest depth (hide.h)
 *   picture    colour, the face in its last channel; depth along forward
 *
 * Row 0 is the picture's uppermost: shaders count from there.
 */
#ifndef OST_RENDER_GL_TARGET_H
#define OST_RENDER_GL_TARGET_H

#include "render/gl/context.h"

typedef struct ost_gl_targets {
    int width, height;   /* 0: nothing was made */
    ost_gl_target kind;  /* of the G-buffer */
    GLuint gbuffer, gbuffer_depth, gbuffer_0, gbuffer_1; /* gbuffer 0: none, FORWARD draws into the picture */
    GLuint tiles, tiles_depth; /* of COMPACT alone */
    int across, down;    /* in tiles */
    float *farthest;     /* owned; of each tile */
    float *depths;       /* owned; of each pixel; NULL until it is asked for */
    GLuint picture, picture_depth, picture_colour;
} ost_gl_targets;

ost_status ost_gl_targets_make(ost_gl_context *context, ost_gl_targets *targets, int width, int height, ost_gl_target kind, ost_error *err);
void ost_gl_targets_free(ost_gl_targets *targets);

#endif
