/* SPDX-License-Identifier: Apache-2.0 */
/* What is drawn of a thing: its blocks in sight, near first, and of their points those that are turned to the eye. */
#ifndef OST_RENDER_GL_CHOOSE_H
#define OST_RENDER_GL_CHOOSE_H

#include "render/gl/insides.h"

ost_status ost_gl_room_for_blocks(ost_gl *gl, int32_t count, ost_error *err);
ost_status ost_gl_room_for_list(ost_gl *gl, uint64_t count, ost_error *err);

/* Into gl->blocks, all cells of which are wanted; l->eye is known. */
void ost_gl_choose_blocks(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l);
/* Whether a brick is the cheaper point for what was chosen. */
bool ost_gl_are_small(const ost_gl *gl, const ost_gl_layer *l);
/* Numbers of the points or bricks of wanted cells, behind those that OpenGL's list has. */
void ost_gl_list_blocks(ost_gl *gl, ost_gl_layer *l);

#endif
