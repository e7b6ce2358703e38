/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/gl/pass.h"

#include <stdlib.h>

#include "render/gl/eye.h"

static void bind(ost_gl_unit unit, GLenum target, GLuint texture)
{
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(target, texture);
}

void ost_gl_bind_layer(ost_gl *gl, int number, ost_gl_form form)
{
    bind(OST_GL_UNIT_PAGES, GL_TEXTURE_BUFFER, ost_gl_store_pool(&gl->store, form)->page_texture);
    bind(OST_GL_UNIT_PALETTE, GL_TEXTURE_BUFFER, gl->layer[number].palette_texture);
    bind(OST_GL_UNIT_POINTS, GL_TEXTURE_BUFFER, gl->store.points.texture);
    bind(OST_GL_UNIT_SHADES, GL_TEXTURE_BUFFER, gl->store.shades.texture);
    bind(OST_GL_UNIT_LIST, GL_TEXTURE_BUFFER, gl->list_texture);
    glBindBufferRange(GL_UNIFORM_BUFFER, OST_GL_EYE, gl->eyes, (GLintptr)number * gl->eye_stride,
                      sizeof(ost_gl_eye_block));
}

static void attribute(GLuint buffer, ost_gl_form form)
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glEnableVertexAttribArray(0);
    glDisableVertexAttribArray(1);
    if (form == OST_GL_VOXELS)
        glVertexAttribIPointer(0, 1, GL_SHORT, sizeof(int16_t), NULL);
    else if (form == OST_GL_BRICKS)
        glVertexAttribIPointer(0, 4, GL_UNSIGNED_INT, 4 * sizeof(uint32_t), NULL);
    else
        glVertexAttribIPointer(0, 2, GL_UNSIGNED_INT, 2 * sizeof(uint32_t), NULL);
}

/* Draws all points of the selected blocks. */
static void draw_runs(ost_gl *gl, const ost_gl_layer *l)
{
    GLsizei n = 0;
    for (int32_t i = 0; i < l->blocks; i++) {
        const ost_gl_run *run = &l->resident->run[l->form][gl->blocks[i].slot];
        gl->firsts[n] = (GLint)run->first;
        gl->counts[n++] = (GLsizei)run->count;
        gl->did.points += run->count;
    }
    glMultiDrawArrays(GL_POINTS, gl->firsts, gl->counts, n);
}

static ost_status draw_mesh(ost_gl *gl, const ost_gl_layer *l, ost_gl_target target, ost_error *err)
{
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_MESH, .target = target};
    ost_status status = ost_gl_programs_use(&gl->context, &gl->programs, &key, NULL, err);
    if (status != OST_OK)
        return status;
    glBindBuffer(GL_ARRAY_BUFFER, l->resident->mesh);
    for (GLuint i = 0; i < 2; i++) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), (const void *)(i * 3 * sizeof(float)));
    }
    glDrawArrays(GL_TRIANGLES, 0, (GLsizei)l->resident->mesh_vertices);
    gl->did.points += l->resident->mesh_vertices;
    return OST_OK;
}

/* Fills the index buffer for blocks of up to `quads` quads: two triangles for each quad. */
static ost_status reserve_indices(ost_gl *gl, uint32_t quads, ost_error *err)
{
    static const uint32_t corner[6] = {0, 1, 2, 0, 2, 3};
    if (quads <= gl->quad_capacity)
        return OST_OK;
    uint32_t capacity = quads + quads / 2;
    capacity = capacity < OST_FACE_QUADS_MAX ? capacity : OST_FACE_QUADS_MAX;
    uint32_t *index = malloc((size_t)capacity * 6 * sizeof *index);
    if (!index)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the indices of %u quads", (unsigned)capacity);
    for (uint32_t i = 0; i < 6 * capacity; i++)
        index[i] = 4 * (i / 6) + corner[i % 6];
    if (!gl->quad_indices)
        glGenBuffers(1, &gl->quad_indices);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, gl->quad_indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)capacity * 6 * sizeof *index), index, GL_STATIC_DRAW);
    free(index);
    gl->quad_capacity = capacity;
    return ost_gl_context_check(&gl->context, "makes the indices of quads", err);
}

/* Draws the quads of the selected blocks. firsts[i] is the index of the first vertex of block i. */
static ost_status draw_quads(ost_gl *gl, const ost_gl_layer *l, ost_error *err)
{
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_QUADS, .page_bits = OST_GL_QUAD_BITS};
    uint32_t most = 0;
    GLsizei n = 0;
    for (int32_t i = 0; i < l->blocks; i++) {
        const ost_gl_run *run = &l->resident->run[OST_GL_QUADS][gl->blocks[i].slot];
        if (run->count == 0)
            continue;
        gl->firsts[n] = (GLint)(4 * run->first);
        gl->counts[n++] = (GLsizei)(6 * run->count);
        gl->did.quads += run->count;
        gl->did.points += 4 * (uint64_t)run->count;
        most = run->count > most ? run->count : most;
    }
    ost_status status = reserve_indices(gl, most, err);
    if (status == OST_OK)
        status = ost_gl_programs_use(&gl->context, &gl->programs, &key, NULL, err);
    if (status != OST_OK || n == 0)
        return status;
    glBindBuffer(GL_ARRAY_BUFFER, gl->store.quads.buffer);
    glEnableVertexAttribArray(0);
    glDisableVertexAttribArray(1);
    glVertexAttribIPointer(0, 1, GL_UNSIGNED_INT, sizeof(uint32_t), NULL);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, gl->quad_indices);
    glMultiDrawElementsBaseVertex(GL_TRIANGLES, gl->counts, GL_UNSIGNED_INT, gl->offsets, n, gl->firsts);
    return OST_OK;
}

ost_status ost_gl_draw_points(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l, ost_error *err)
{
    ost_gl_program_key key = {
        .stage = l->form == OST_GL_BRICKS ? OST_GL_STAGE_BRICKS : OST_GL_STAGE_POINTS,
        .target = v->target,
        .every_voxel = v->every_voxel,
        .tight = v->tight,
        .lines = v->lines,
        .true_depth = v->true_depth,
        .page_bits = ost_gl_store_pool(&gl->store, l->form)->bits,
    };
    GLint first;
    ost_status status = OST_OK;
    if (l->form == OST_GL_QUADS)
        return draw_quads(gl, l, err);
    if (l->mesh)
        return draw_mesh(gl, l, v->target, err);
    if (l->listed && l->near && v->tight) {
        key.quads = true;
        status = ost_gl_programs_use(&gl->context, &gl->programs, &key, &first, err);
        if (status != OST_OK)
            return status;
        glUniform1i(first, (GLint)l->begin);
        glDisableVertexAttribArray(0);
        glDisableVertexAttribArray(1);
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, (GLsizei)l->near);
        key.quads = false;
    } else {
        l->near = 0;
    }
    status = ost_gl_programs_use(&gl->context, &gl->programs, &key, &first, err);
    if (status != OST_OK)
        return status;
    attribute(ost_gl_store_pool(&gl->store, l->form)->buffer, l->form);
    if (!l->listed) {
        draw_runs(gl, l);
        return OST_OK;
    }
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, gl->list);
    glDrawElements(GL_POINTS, (GLsizei)(l->count - l->near), GL_UNSIGNED_INT,
                   (const void *)((l->begin + l->near) * sizeof(uint32_t)));
    gl->did.points += l->count;
    return OST_OK;
}

void ost_gl_clear_gbuffer(ost_gl_target kind)
{
    static const GLuint none[4] = {OST_NO_FACE << 24, 0x3f800000 /* 1.0f */, 0, 0};
    static const GLfloat nothing[4] = {0, 0, 0, 0}, back[4] = {0x16 / 255.0f, 0x18 / 255.0f, 0x1c / 255.0f, 6 / 255.0f},
                         far = 1;
    _Static_assert(OST_BACKGROUND == 0x1c1816, "the colour that a forward frame is cleared to");
    if (kind == OST_GL_COMPACT)
        glClearBufferuiv(GL_COLOR, 0, none);
    else
        glClearBufferfv(GL_COLOR, 0, kind == OST_GL_FORWARD ? back : nothing);
    if (kind == OST_GL_WIDE || kind == OST_GL_SMALL)
        glClearBufferfv(GL_COLOR, 1, nothing);
    glClearBufferfv(GL_DEPTH, 0, &far);
}

ost_status ost_gl_composite(ost_gl *gl, const ost_gl_program_key *key, bool first, ost_error *err)
{
    const ost_gl_targets *t = &gl->targets;
    ost_status status = ost_gl_programs_use(&gl->context, &gl->programs, key, NULL, err);
    if (status != OST_OK)
        return status;
    glBindFramebuffer(GL_FRAMEBUFFER, t->picture);
    bind(OST_GL_UNIT_SEEN, GL_TEXTURE_2D, t->kind == OST_GL_COMPACT ? t->gbuffer_0 : 0);
    bind(OST_GL_UNIT_NORMALS, GL_TEXTURE_2D, t->kind == OST_GL_COMPACT ? 0 : t->gbuffer_0);
    bind(OST_GL_UNIT_COLOURS, GL_TEXTURE_2D, t->gbuffer_1);
    bind(OST_GL_UNIT_DEPTHS, GL_TEXTURE_2D, t->gbuffer_depth);
    glDepthFunc(first ? GL_ALWAYS : GL_LESS);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return OST_OK;
}

ost_status ost_gl_read_tiles(ost_gl *gl, ost_error *err)
{
    const ost_gl_targets *t = &gl->targets;
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_TILES};
    ost_status status = ost_gl_programs_use(&gl->context, &gl->programs, &key, NULL, err);
    if (status != OST_OK)
        return status;
    glBindFramebuffer(GL_FRAMEBUFFER, t->tiles);
    glViewport(0, 0, t->across, t->down);
    bind(OST_GL_UNIT_DEPTHS, GL_TEXTURE_2D, t->gbuffer_depth);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glReadPixels(0, 0, t->across, t->down, GL_RED, GL_FLOAT, t->farthest);
    return ost_gl_context_check(&gl->context, "reads depths", err);
}

void ost_gl_bind_shown(const ost_gl *gl)
{
    bind(OST_GL_UNIT_PICTURE, GL_TEXTURE_2D, gl->targets.picture_colour);
    bind(OST_GL_UNIT_SHEET, GL_TEXTURE_2D, gl->sheet);
}

ost_status ost_gl_read_depths(ost_gl *gl, float *depths, ost_error *err)
{
    glReadPixels(0, 0, gl->targets.width, gl->targets.height, GL_DEPTH_COMPONENT, GL_FLOAT, depths);
    return ost_gl_context_check(&gl->context, "reads depths", err);
}

void ost_gl_set_state(const ost_gl *gl)
{
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glViewport(0, 0, gl->targets.width, gl->targets.height);
    glBindVertexArray(gl->vertices);
    if (gl->context.zero_to_one)
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}
