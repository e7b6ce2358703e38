/* SPDX-License-Identifier: Apache-2.0 */
#include "app/render/render.h"

#include "app/common/print.h"
#include "app/common/result.h"

static const char *const renderer_names[] = {"points", "auto", "gl", "mesh", "thesis"};

/* Reports the mesh of the picture: its size, and the time in which the backend made it. */
static void print_mesh(const app_state *app, const ost_gl *gl)
{
    const ost_gl_counts c = ost_gl_counts_get(gl);
    json_t *o = json_object();
    char chunks[FORMAT_TEXT], quads[FORMAT_TEXT], a[FORMAT_TEXT];
    put_integer(o, "chunks", (int64_t)c.meshed);
    put_integer(o, "drawn_faces", (int64_t)c.quads);
    put_integer(o, "bytes", (int64_t)c.uploaded);
    put_real(o, "mesh_ms", (double)c.mesh_ns * 1e-6);
    put_real(o, "copy_ms", (double)c.copy_ns * 1e-6);
    put(app->result, "mesh", o);
    print_line(app, "  %s chunks meshed in %s, %s faces drawn", format_count(chunks, (int64_t)c.meshed),
               format_time(a, (double)c.mesh_ns * 1e-6), format_count(quads, (int64_t)c.quads));
}

static void print_gl(const app_state *app, const ost_gl *gl)
{
    const ost_gl_info info = ost_gl_info_get(gl);
    json_t *o = json_object();
    put_text(o, "version", info.version);
    put_text(o, "driver", info.driver);
    put_text(o, "way", info.way);
    put_bool(o, "software", info.software);
    put(app->result, "opengl", o);
    print_line(app, "  by OpenGL %s, %s, %s", info.version, info.driver, info.way);
}

void render_report(const app_state *app, const render_args *args, const render_drawing *d, const ost_digest *file)
{
    char a[FORMAT_TEXT], n[FORMAT_TEXT];
    put_text(app->result, "out", args->out);
    put_digest(app->result, "file_sha256", file);
    put_text(app->result, "renderer",
             renderer_names[args->renderer != RENDERER_AUTO ? args->renderer
                            : d->viewer.gl                  ? RENDERER_GL
                                                           : RENDERER_POINTS]);
    put_integer(app->result, "width", args->width);
    put_integer(app->result, "height", args->height);
    put_integer(app->result, "surface_voxels", (int64_t)d->viewer.bone.points);
    put_real(app->result, "time_ms", d->draw_ms);
    print_line(app, "%s: %d x %d pixels of %s surface voxels, drawn in %s", args->out, args->width, args->height,
               format_count(n, (int64_t)d->viewer.bone.points), format_time(a, d->draw_ms));
    if (d->viewer.gl)
        print_gl(app, d->viewer.gl);
    if (*d->viewer.no_card) {
        put_text(app->result, "no_card", d->viewer.no_card);
        print_line(app, "  by the processor: %s", d->viewer.no_card);
    }
    if (d->viewer.gl && args->renderer == RENDERER_MESH)
        print_mesh(app, d->viewer.gl);
}
