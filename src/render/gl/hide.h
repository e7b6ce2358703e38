/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cells of 8^3 voxels that others hide are left out, and no pixel changes by it:
 *
 *   cells seen in the last frame --drawn--> depth --the farthest of each 8 x 8 pixels--> tiles, read back
 *   every cell: its pixels and nearest depth --against the tiles--> whether it may be seen in this frame
 *   those that may and were not drawn --drawn--> depth
 *
 * What was seen last is a guess as to who hides the others, and costs time
 * alone where it is wrong.  A cell is left out when all tiles that it may
 * cover are filled by what is nearer than all of it; later points only make a
 * tile nearer.  Depth is the squared distance of centres, so the nearest is
 * that of the centre nearest to the eye, with room for rounding.
 *
 * Cells, not blocks of 32^3: bone is thin, and the box about a piece of a
 * block hides behind another where the block's own box looks out.
 *
 * A shader finds the tiles, and a few kilobytes come back; where OpenGL is
 * software all depths do, which takes it less time than the shader.
 */
#ifndef OST_RENDER_GL_HIDE_H
#define OST_RENDER_GL_HIDE_H

#include "render/gl/insides.h"

/* Whether that is done to this layer. */
bool ost_gl_hide_wanted(const ost_gl_variant *v, const ost_gl_layer *l, int number);
/* Wanted are the cells that were seen last. */
void ost_gl_hide_guess(ost_gl *gl, const ost_gl_layer *l);
/* They are drawn: wanted are those that are missing. Another framebuffer, viewport and program may be set afterwards. */
ost_status ost_gl_hide_look(ost_gl *gl, const ost_gl_variant *v, const ost_gl_layer *l, bool *missing, ost_error *err);

#endif
