/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the parts of an object to draw: the blocks in view, in order of increasing distance, and the points with a
   face toward the eye. */
#ifndef OST_RENDER_GL_CHOOSE_H
#define OST_RENDER_GL_CHOOSE_H

#include "render/gl/insides.h"

ost_status ost_gl_reserve_blocks(ost_gl *gl, int32_t count, ost_error *err);
ost_status ost_gl_reserve_list(ost_gl *gl, uint64_t count, ost_error *err);

/* Writes to gl->blocks the blocks to draw, and marks all cells of these blocks as wanted. l->eye must be set. */
void ost_gl_choose_blocks(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l);
/* Returns true if the selected blocks are drawn faster as bricks than as single points. */
bool ost_gl_are_small(const ost_gl *gl, const ost_gl_layer *l);
/* Appends the numbers of the points or bricks in wanted cells to OpenGL's list of vertices. */
void ost_gl_list_blocks(ost_gl *gl, ost_gl_layer *l);

#endif
