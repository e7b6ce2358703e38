/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws the last picture into a framebuffer, for example that of a window, without reading it back.
 *
 *   picture --smooth the edges (show.frag)--> colours --sheet over them--> framebuffer
 *   sheet --changed cells--> texture
 */
#include "render/gl/insides.h"
#include "render/gl/pass.h"

/*
 * Creates the texture of the sheet if its size has changed. Sets *fresh to true if the texture is new and therefore
 * empty.
 */
static ost_status reserve_sheet(ost_gl *gl, int width, int height, bool *fresh, ost_error *err)
{
    *fresh = gl->sheet_width != width || gl->sheet_height != height;
    if (!*fresh)
        return OST_OK;
    glDeleteTextures(1, &gl->sheet); /* ignores 0 */
    gl->sheet_width = gl->sheet_height = 0;
    gl->sheet = ost_gl_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
    ost_status status = ost_gl_context_check(&gl->context, "makes the layer over a frame", err);
    if (status == OST_OK) {
        gl->sheet_width = width;
        gl->sheet_height = height;
    }
    return status;
}

static void upload(const ost_gl_sheet *sheet, ost_cells_box b)
{
    glTexSubImage2D(GL_TEXTURE_2D, 0, b.x0, b.y0, b.x1 - b.x0, b.y1 - b.y0, GL_RGBA, GL_UNSIGNED_BYTE,
                    sheet->pixels + (size_t)b.y0 * (size_t)sheet->stride + b.x0);
}

static void upload_cells(const ost_gl_sheet *sheet)
{
    const ost_cells *cells = sheet->changed;
    for (int row = 0; row < cells->rows; row++)
        for (int from, to = 0; ost_cells_run(cells, row, &from, &to);)
            upload(sheet, ost_cells_box_of(cells, row, from, to));
}

static ost_status bring_sheet(ost_gl *gl, const ost_gl_sheet *sheet, ost_error *err)
{
    bool fresh;
    ost_status status = reserve_sheet(gl, gl->targets.width, gl->targets.height, &fresh, err);
    if (status != OST_OK)
        return status;
    glBindTexture(GL_TEXTURE_2D, gl->sheet);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, sheet->stride);
    if (fresh || !sheet->changed)
        upload(sheet, (ost_cells_box){0, gl->targets.width, 0, gl->targets.height});
    else
        upload_cells(sheet);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    return ost_gl_context_check(&gl->context, "copies the layer over a frame", err);
}

typedef struct showing {
    ost_gl *gl;
    GLuint framebuffer;
    bool antialiased;
    const ost_gl_sheet *sheet;
} showing;

static ost_status show_here(void *user, ost_error *err)
{
    const showing *s = user;
    ost_gl *gl = s->gl;
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_SHOW, .antialiased = s->antialiased};
    ost_status status = bring_sheet(gl, s->sheet, err);
    if (status == OST_OK)
        status = ost_gl_programs_use(&gl->context, &gl->programs, &key, NULL, err);
    if (status != OST_OK)
        return status;
    ost_gl_set_state(gl);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    ost_gl_bind_shown(gl);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return ost_gl_context_check(&gl->context, "shows a frame", err);
}

ost_status ost_gl_show(ost_gl *gl, unsigned framebuffer, bool antialiased, const ost_gl_sheet *sheet, ost_error *err)
{
    return ost_gl_worker_do(gl->worker, show_here, &(showing){gl, framebuffer, antialiased, sheet}, err);
}
