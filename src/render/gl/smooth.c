/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/smooth.h"

#include <stddef.h>

#include "render/gl/pass.h"

/* Returns the buffer of a mesh. If the mesh has no buffer, it gets a free buffer or, if no buffer is free, the oldest
 * buffer. */
static GLuint buffer_of(ost_gl *gl, const ost_smooth_mesh *mesh)
{
    for (int i = 0; i < OST_GL_SMOOTH; i++)
        if (gl->smooth[i].buffer && gl->smooth[i].hash == mesh->hash && gl->smooth[i].count == mesh->count)
            return gl->smooth[i].buffer;
    ost_gl_smooth_mesh *to = &gl->smooth[gl->smooth_next++ % OST_GL_SMOOTH];
    if (!to->buffer)
        glGenBuffers(1, &to->buffer);
    to->hash = mesh->hash;
    to->count = mesh->count;
    glBindBuffer(GL_ARRAY_BUFFER, to->buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(mesh->count * sizeof *mesh->triangle), mesh->triangle, GL_STATIC_DRAW);
    gl->store.uploaded += mesh->count * sizeof *mesh->triangle;
    return to->buffer;
}

ost_status ost_gl_smooth_draw(ost_gl *gl, int number, ost_error *err)
{
    static const size_t first[2] = {offsetof(ost_smooth_corner, at), offsetof(ost_smooth_corner, normal)};
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_SMOOTH};
    const ost_smooth_mesh *mesh = gl->layer[number].thing->mesh;
    const GLsizei corners = (GLsizei)(3 * mesh->count);
    ost_status status = ost_gl_programs_use(&gl->context, &gl->programs, &key, NULL, err);
    if (status != OST_OK)
        return status;
    glBindFramebuffer(GL_FRAMEBUFFER, gl->targets.picture);
    ost_gl_bind_layer(gl, number, gl->layer[number].form);
    glDepthFunc(GL_LESS);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_of(gl, mesh));
    for (GLuint i = 0; i < 2; i++) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, sizeof(ost_smooth_corner), (const void *)first[i]);
    }
    glDrawArrays(GL_TRIANGLES, 0, corners);
    gl->did.points += (uint64_t)corners;
    return OST_OK;
}

void ost_gl_smooth_free(ost_gl *gl)
{
    for (int i = 0; i < OST_GL_SMOOTH; i++)
        glDeleteBuffers(1, &gl->smooth[i].buffer);
}
