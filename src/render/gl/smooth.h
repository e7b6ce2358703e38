/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the smooth mesh of a tool (points/smooth_mesh.h) over the picture, where it is nearer. */
#ifndef OST_RENDER_GL_SMOOTH_H
#define OST_RENDER_GL_SMOOTH_H

#include "render/gl/insides.h"

/* Uploads the mesh of layer `number`, unless it is in a buffer, and draws it into the picture. */
ost_status ost_gl_smooth_draw(ost_gl *gl, int number, ost_error *err);
void ost_gl_smooth_free(ost_gl *gl);

#endif
