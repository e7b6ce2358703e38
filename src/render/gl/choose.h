/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the parts of an object to draw: the blocks in view, nearest first, and the points of these blocks that have a
 * face toward the eye. */
#ifndef OST_RENDER_GL_CHOOSE_H
#define OST_RENDER_GL_CHOOSE_H

#include "render/gl/insides.h"

ost_status ost_gl_reserve_blocks(ost_gl *gl, int32_t count, ost_error *err);
ost_status ost_gl_reserve_list(ost_gl *gl, uint64_t count, ost_error *err);

/* Selects the blocks to draw, stores them in gl->blocks, and marks all of their cells as wanted. l->eye must be set. */
void ost_gl_choose_blocks(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l);
/* Returns true if the selected blocks are drawn faster as bricks than as points, because their voxels appear small. */
bool ost_gl_are_small(const ost_gl *gl, const ost_gl_layer *l);
/* Appends the numbers of the points or bricks in wanted cells to the list of vertices to draw. */
void ost_gl_list_blocks(ost_gl *gl, ost_gl_layer *l);

#endif
