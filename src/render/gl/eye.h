/* SPDX-License-Identifier: Apache-2.0 */
/* What every stage knows of a thing's camera and light: eye.glsl's block, and its palette. */
#ifndef OST_RENDER_GL_EYE_H
#define OST_RENDER_GL_EYE_H

#include "render/gl/insides.h"

/* eye.glsl, std140. */
typedef struct ost_gl_eye_block {
    float at[4], right[4], up[4], forward[4], axis[3][4], frame[4], layer[4];
    uint32_t light_0[4], light_4[4], paint[4];
} ost_gl_eye_block;

/* Of the layer of that number, whose blocks are chosen. */
void ost_gl_put_eye(ost_gl *gl, int number, ost_style style);

#endif
