/* SPDX-License-Identifier: Apache-2.0 */
/* Provides the uniforms of an object's camera and light, which every shader stage uses. These are the uniform block of
   eye.glsl and the palette. */
#ifndef OST_RENDER_GL_EYE_H
#define OST_RENDER_GL_EYE_H

#include "render/gl/insides.h"

/* Has the std140 layout of the uniform block of eye.glsl. */
typedef struct ost_gl_eye_block {
    float at[4], right[4], up[4], forward[4], axis[3][4], frame[4], layer[4];
    uint32_t light_0[4], light_4[4], paint[4];
} ost_gl_eye_block;

/* Writes the uniforms of layer `number`. The layer's blocks must already be selected. */
void ost_gl_put_eye(ost_gl *gl, int number, ost_style style);

#endif
