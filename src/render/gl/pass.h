/* SPDX-License-Identifier: Apache-2.0 */
/* Issues the OpenGL draw calls that draw points into a G-buffer and composite the G-buffer into the picture. */
#ifndef OST_RENDER_GL_PASS_H
#define OST_RENDER_GL_PASS_H

#include "render/gl/insides.h"

/* Sets the OpenGL state that stays constant for the complete frame. */
void ost_gl_set_state(const ost_gl *gl);
void ost_gl_clear_gbuffer(ost_gl_target kind);
/* Binds the uniforms and textures of layer `number` for the following draw calls. */
void ost_gl_bind_layer(ost_gl *gl, int number, ost_gl_form form);
/* Draws the points in the list or, if there is no list, all points of the selected blocks. */
ost_status ost_gl_draw_points(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l, ost_error *err);
/*
 * Reads the maximum depth of each tile of the G-buffer into gl->targets.farthest. Changes OpenGL's state, so the caller
 * must call ost_gl_set_state and bind a framebuffer afterwards.
 */
ost_status ost_gl_read_tiles(ost_gl *gl, ost_error *err);
/* Binds the textures of the picture and of the sheet over it. */
void ost_gl_bind_shown(const ost_gl *gl);
/* Reads the depth of each pixel of the G-buffer. The G-buffer must be the bound framebuffer. */
ost_status ost_gl_read_depths(ost_gl *gl, float *depths, ost_error *err);
/*
 * Lights the G-buffer and writes it to the picture. If `first` is true, all pixels are written; otherwise, only those
 * that are nearer than the picture's pixels.
 */
ost_status ost_gl_composite(ost_gl *gl, const ost_gl_program_key *key, bool first, ost_error *err);

#endif
