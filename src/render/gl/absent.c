/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the functions of gl.h in a build without libepoxy, in which OpenGL is never available. */
#include "render/gl/gl.h"

const ost_gl_variant ost_gl_ours, ost_gl_thesis, ost_gl_mesh;

const char *ost_gl_missing(void)
{
    return "no --renderer gl, mesh or thesis; install libepoxy-dev and build again";
}

ost_status ost_gl_open(const ost_gl_options *options, ost_gl **out, ost_error *err)
{
    (void)options;
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "osteon was built without OpenGL; Debian: install libepoxy-dev and build again");
}

void ost_gl_close(ost_gl *gl)
{
    (void)gl;
}

void ost_gl_abandon(ost_gl *gl)
{
    (void)gl;
}

ost_gl_info ost_gl_info_get(const ost_gl *gl)
{
    (void)gl;
    return (ost_gl_info){.version = ""};
}

void ost_gl_set_mesher(ost_gl *gl, ost_backend *mesher)
{
    (void)gl;
    (void)mesher;
}

ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count,
                       ost_style style, ost_error *err)
{
    (void)gl;
    (void)variant;
    (void)things;
    (void)count;
    (void)style;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}

ost_status ost_gl_finish(ost_gl *gl, ost_error *err)
{
    (void)gl;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}

ost_status ost_gl_read(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err)
{
    (void)gl;
    (void)frame;
    (void)depth;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}

ost_gl_counts ost_gl_counts_get(const ost_gl *gl)
{
    (void)gl;
    return (ost_gl_counts){0};
}

ost_gl_egl ost_gl_egl_get(const ost_gl *gl)
{
    (void)gl;
    return (ost_gl_egl){0};
}

ost_status ost_gl_do(ost_gl *gl, ost_gl_function *function, void *user, ost_error *err)
{
    (void)gl;
    (void)function;
    (void)user;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}

ost_status ost_gl_copy(ost_gl *gl, unsigned texture, ost_error *err)
{
    (void)gl;
    (void)texture;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}

ost_status ost_gl_show(ost_gl *gl, unsigned framebuffer, bool antialiased, const ost_gl_sheet *sheet, ost_error *err)
{
    (void)gl;
    (void)framebuffer;
    (void)antialiased;
    (void)sheet;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", ost_gl_missing());
}
