/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Skips cells of 8^3 voxels that are hidden by other cells, without changing any pixel:
 *
 *   cells visible in the last frame --drawn--> depth --the farthest of each 8 x 8 pixels--> tiles, read back
 *   every cell: its pixels and nearest depth --compared with the tiles--> cells that may be visible in this frame
 *   such cells, if they were not drawn yet --drawn--> depth
 *
 * The cells that were visible in the last frame are drawn first, because they probably hide the other cells. If they do
 * not, drawing takes longer, but the picture is the same. A cell is skipped if every tile that it may cover is
 * completely filled with points nearer than all voxels of the cell. The depth of a voxel is the squared distance of its
 * centre. A lower bound on the depths in a cell is therefore the squared distance of the nearest centre, minus a margin
 * for rounding. Points that are drawn later can only decrease the depths of a tile.
 *
 * Cells are tested in addition to blocks of 32^3 voxels. Because bone is thin, a cell is often hidden although its
 * block is not.
 *
 * A shader computes the tiles, and a few kilobytes are read back. With a software renderer, all depths are read back,
 * which is faster than the shader.
 */
#ifndef OST_RENDER_GL_HIDE_H
#define OST_RENDER_GL_HIDE_H

#include "render/gl/insides.h"

/* Returns true if hidden cells of this layer should be skipped. */
bool ost_gl_hide_wanted(const ost_gl_variant *v, const ost_gl_layer *l, int number);
/* Sets gl->wanted to the cells that were visible in the last frame. */
void ost_gl_hide_guess(ost_gl *gl, const ost_gl_layer *l);
/*
 * Called after the wanted cells have been drawn. Sets gl->wanted to the cells that may be visible but have not been
 * drawn, and *missing to true if there are any. May change the framebuffer, the viewport and the program.
 */
ost_status ost_gl_hide_test(ost_gl *gl, const ost_gl_variant *v, const ost_gl_layer *l, bool *missing, ost_error *err);

#endif
