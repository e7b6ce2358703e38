/* SPDX-License-Identifier: Apache-2.0 */
/* The uniforms that every shader stage uses: the camera and the light of an object, in the uniform block of
   eye.glsl, and the palette. */
#ifndef OST_RENDER_GL_EYE_H
#define OST_RENDER_GL_EYE_H

#include "render/gl/insides.h"

/* Must match the uniform block of eye.glsl in std140 layout. */
typedef struct ost_gl_eye_block {
    float at[4], right[4], up[4], forward[4], axis[3][4], frame[4], layer[4];
    uint32_t light_0[4], light_4[4], paint[4];
} ost_gl_eye_block;

/* Uploads the uniforms of layer `number`. The layer's blocks must have been selected. */
void ost_gl_put_eye(ost_gl *gl, int number, ost_style style);

#endif
