/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The source texts of the shaders, which build-aux/source-strings embeds in the library. Each part begins with #line.
 */
#ifndef OST_RENDER_GL_EMBEDDED_H
#define OST_RENDER_GL_EMBEDDED_H

#include <stddef.h>

#define OST_GL_EMBEDDED(NAME)                \
    extern const char *const ost_gl_##NAME[]; \
    extern const size_t ost_gl_##NAME##_count
OST_GL_EMBEDDED(point_vert);
OST_GL_EMBEDDED(point_frag);
OST_GL_EMBEDDED(brick_vert);
OST_GL_EMBEDDED(brick_frag);
OST_GL_EMBEDDED(mesh_vert);
OST_GL_EMBEDDED(smooth_vert);
OST_GL_EMBEDDED(smooth_frag);
OST_GL_EMBEDDED(mesh_frag);
OST_GL_EMBEDDED(quad_vert);
OST_GL_EMBEDDED(quad_frag);
OST_GL_EMBEDDED(tiles_frag);
OST_GL_EMBEDDED(show_frag);
OST_GL_EMBEDDED(whole_vert);
OST_GL_EMBEDDED(composite_frag);
OST_GL_EMBEDDED(composite_wide_frag);

#endif
