/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the smooth mesh of a tool (points/smooth_mesh.h) into the picture, in the pixels where the mesh is nearer. */
#ifndef OST_RENDER_GL_SMOOTH_H
#define OST_RENDER_GL_SMOOTH_H

#include "render/gl/insides.h"

/* Draws the mesh of layer `number` into the picture. Uploads the mesh first if necessary. */
ost_status ost_gl_smooth_draw(ost_gl *gl, int number, ost_error *err);
void ost_gl_smooth_free(ost_gl *gl);

#endif
