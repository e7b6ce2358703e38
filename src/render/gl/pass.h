/* SPDX-License-Identifier: Apache-2.0 */
/* The calls that draw: points into a G-buffer, and that into the picture. */
#ifndef OST_RENDER_GL_PASS_H
#define OST_RENDER_GL_PASS_H

#include "render/gl/insides.h"

/* What all of a frame has. */
void ost_gl_set_state(const ost_gl *gl);
void ost_gl_clear_gbuffer(ost_gl_target kind);
/* Of the layer of that number, for what is drawn next. */
void ost_gl_bind_layer(ost_gl *gl, int number, ost_gl_form form);
/* Of the chosen blocks, by the list where there is one. */
ost_status ost_gl_draw_points(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l, ost_error *err);
/* The farthest depth of each tile of the G-buffer, into gl->targets.farthest; set_state and a framebuffer come after it. */
ost_status ost_gl_read_tiles(ost_gl *gl, ost_error *err);
/* The depth of each pixel of the G-buffer, which is the framebuffer now. */
ost_status ost_gl_read_depths(ost_gl *gl, float *depths, ost_error *err);
/* first: over all that the picture has; else where it is nearer. */
ost_status ost_gl_composite(ost_gl *gl, const ost_gl_program_key *key, bool first, ost_error *err);

#endif
