/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Skips cells of 8^3 voxels that other cells hide. This changes no pixel:
 *
 *   cells visible in the last frame --drawn--> depth --the farthest of each 8 x 8 pixels--> tiles, read back
 *   every cell: its pixels and nearest depth --compared with the tiles--> cells that may be visible in this frame
 *   cells of these that were not drawn yet --drawn--> depth
 *
 * The cells visible in the last frame are a guess at those that hide the others. A wrong guess
 * costs time but does not change the picture. A cell is skipped if all tiles that it may cover are
 * filled by points that are nearer than the entire cell. Points drawn later can only make a tile
 * nearer. Depth is the squared distance of centres, so a cell's nearest depth is that of its centre
 * nearest to the eye, with a margin for rounding.
 *
 * The unit is a cell and not a block of 32^3 voxels, because bone is thin: a small box around a
 * part of a block can be hidden even if the box of the complete block is not hidden.
 *
 * A shader computes the tiles, and a few kilobytes are read back. With a software renderer, all
 * depths are read back, which is faster than the shader.
 */
#ifndef OST_RENDER_GL_HIDE_H
#define OST_RENDER_GL_HIDE_H

#include "render/gl/insides.h"

/* Returns true if hidden cells of this layer must be skipped. */
bool ost_gl_hide_wanted(const ost_gl_variant *v, const ost_gl_layer *l, int number);
/* Sets gl->wanted to the cells that were visible in the last frame. */
void ost_gl_hide_guess(ost_gl *gl, const ost_gl_layer *l);
/*
 * Called after the wanted cells were drawn. Sets gl->wanted to the cells that were not drawn
 * although they may be visible, and *missing to true if there are any. May change the framebuffer,
 * the viewport and the program.
 */
ost_status ost_gl_hide_test(ost_gl *gl, const ost_gl_variant *v, const ost_gl_layer *l, bool *missing, ost_error *err);

#endif
