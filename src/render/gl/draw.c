/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame by OpenGL, thing by thing:
 *
 *   changed blocks --> pools          (resident.c)
 *   blocks in sight, near first       (points/blocks.h)
 *   points turned to the eye          --> list of vertices
 *   G-buffer cleared, points drawn, composite over what is there
 *
 * The distance of a voxel's centre, squared, is exact as a depth where depth
 * goes from 0 to 1 (4.5): a power of two times the float that the processor's
 * renderer compares.  Before that it is rounded to 24 bits of the farthest.
 */
#include "core/conditions.h"
#include "render/gl/context.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "render/gl/programs.h"
#include "render/gl/resident.h"
#include "render/gl/target.h"
#include "render/gl/worker.h"

const ost_gl_variant ost_gl_ours = {.frustum = true, .facing = true, .order = true, .tight = true, .lines = true, .choose = true};
const ost_gl_variant ost_gl_thesis = {.every_voxel = true, .true_depth = true, .target = OST_GL_WIDE};

/* eye.glsl, std140. */
typedef struct eye_block {
    float at[4], right[4], up[4], forward[4], axis[3][4], frame[4], layer[4];
    uint32_t light_0[4], light_4[4], paint[4];
} eye_block;

/* A thing on its way through a frame. */
typedef struct layer {
    const ost_frame_thing *thing;
    ost_splat_eye eye;
    ost_gl_resident *resident;
    ost_gl_form form;
    bool mesh;
    GLuint palette, palette_texture;
    uint32_t begin, near, count; /* in the list: its first entry, how many of them as quads, how many in all */
    int32_t blocks;              /* chosen */
    int y0, y1;
} layer;

struct ost_gl {
    ost_gl_worker *worker; /* all below is its, but for what is read while it rests */
    ost_gl_context context;
    ost_gl_store store;
    ost_gl_programs programs;
    ost_gl_targets targets;
    GLuint eyes, vertices;  /* uniforms, a vertex array */
    GLint eye_stride;
    GLuint list, list_texture;
    void *list_mapped;
    uint32_t list_room, list_used;
    uint32_t *numbers;      /* owned; of list_room */
    layer layer[OST_FRAME_LAYERS];
    ost_frame_block *blocks; /* owned; of block_room */
    float *bases;           /* owned; 4 a block */
    GLint *firsts;          /* owned; of block_room, and counts */
    GLsizei *counts;
    int32_t block_room;
    ost_light light;
    ost_directions directions;
    uint32_t palette[OST_OCTAHEDRAL_COUNT + OST_PAINTS];
    GLsync fence;           /* of the last frame; NULL: none, or waited for */
    ost_gl_counts did;
};

/* ------------------------------------------------------------- open, close */

static ost_status make(ost_gl *gl, ost_error *err)
{
    GLint alignment = 1;
    ost_directions_make(&gl->directions);
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    gl->eye_stride = ((GLint)sizeof(eye_block) + alignment - 1) / alignment * alignment;
    glGenVertexArrays(1, &gl->vertices);
    glGenBuffers(1, &gl->eyes);
    glBindBuffer(GL_UNIFORM_BUFFER, gl->eyes);
    glBufferData(GL_UNIFORM_BUFFER, (GLsizeiptr)gl->eye_stride * OST_FRAME_LAYERS, NULL, GL_STREAM_DRAW);
    for (int i = 0; i < OST_FRAME_LAYERS; i++) {
        layer *l = &gl->layer[i];
        glGenBuffers(1, &l->palette);
        glBindBuffer(GL_TEXTURE_BUFFER, l->palette);
        glBufferData(GL_TEXTURE_BUFFER, sizeof gl->palette, NULL, GL_STREAM_DRAW);
        l->palette_texture = ost_gl_buffer_texture(l->palette, GL_R32UI);
    }
    return ost_gl_context_check(&gl->context, "begins", err);
}

typedef struct opening {
    ost_gl *gl;
    const ost_gl_options *options;
} opening;

static ost_status open_here(void *user, ost_error *err)
{
    const opening *o = user;
    ost_status status = ost_gl_context_open(&o->gl->context, o->options, err);
    return status == OST_OK ? make(o->gl, err) : status;
}

static ost_status close_here(void *user, ost_error *err)
{
    ost_gl *gl = user;
    (void)err;
    if (gl->context.context == EGL_NO_CONTEXT)
        return OST_OK;
    if (gl->fence)
        glDeleteSync(gl->fence);
    for (int i = 0; i < OST_FRAME_LAYERS; i++) {
        glDeleteBuffers(1, &gl->layer[i].palette);
        glDeleteTextures(1, &gl->layer[i].palette_texture);
    }
    glDeleteBuffers(1, &gl->list);
    glDeleteTextures(1, &gl->list_texture);
    glDeleteBuffers(1, &gl->eyes);
    glDeleteVertexArrays(1, &gl->vertices);
    ost_gl_programs_free(&gl->programs);
    ost_gl_targets_free(&gl->targets);
    ost_gl_store_free(&gl->store);
    ost_gl_context_close(&gl->context);
    return OST_OK;
}

ost_status ost_gl_open(const ost_gl_options *options, ost_gl **out, ost_error *err)
{
    const ost_gl_options o = options ? *options : (ost_gl_options){0};
    *out = NULL;
    ost_gl *gl = calloc(1, sizeof *gl);
    if (!gl)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a renderer");
    gl->context.context = EGL_NO_CONTEXT;
    ost_gl_store_init(&gl->store);
    ost_status status = ost_gl_worker_start(&gl->worker, err);
    if (status == OST_OK)
        status = ost_gl_worker_do(gl->worker, open_here, &(opening){gl, &o}, err);
    if (status != OST_OK) {
        ost_gl_close(gl);
        return status;
    }
    *out = gl;
    return OST_OK;
}

void ost_gl_close(ost_gl *gl)
{
    if (!gl)
        return;
    if (gl->worker)
        ost_gl_worker_do(gl->worker, close_here, gl, NULL);
    ost_gl_worker_stop(gl->worker);
    free(gl->numbers);
    free(gl->blocks);
    free(gl->bases);
    free(gl->firsts);
    free(gl->counts);
    free(gl);
}

ost_gl_info ost_gl_info_get(const ost_gl *gl)
{
    return gl->context.info;
}

ost_gl_counts ost_gl_counts_get(const ost_gl *gl)
{
    return gl->did;
}

/* What the last frame reads may be written from here on. */
static ost_status wait_for_last(ost_gl *gl, ost_error *err)
{
    if (!gl->fence)
        return OST_OK;
    GLenum is;
    do
        is = glClientWaitSync(gl->fence, GL_SYNC_FLUSH_COMMANDS_BIT, 1000000000);
    while (is == GL_TIMEOUT_EXPIRED);
    glDeleteSync(gl->fence);
    gl->fence = NULL;
    return ost_gl_context_check(&gl->context, "ends a frame", err);
}

/* ------------------------------------------------------------------- room */

static ost_status room_for_blocks(ost_gl *gl, int32_t count, ost_error *err)
{
    if (count <= gl->block_room)
        return OST_OK;
    free(gl->blocks);
    free(gl->bases);
    free(gl->firsts);
    free(gl->counts);
    gl->blocks = malloc((size_t)count * sizeof *gl->blocks);
    gl->bases = malloc((size_t)count * 4 * sizeof *gl->bases);
    gl->firsts = malloc((size_t)count * sizeof *gl->firsts);
    gl->counts = malloc((size_t)count * sizeof *gl->counts);
    gl->block_room = gl->blocks && gl->bases && gl->firsts && gl->counts ? count : 0;
    return gl->block_room ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "no memory to draw %d blocks", (int)count);
}

static ost_status room_for_list(ost_gl *gl, uint64_t count, ost_error *err)
{
    GLint limit = 0;
    const uint64_t room = count + count / 4 + 1024;
    if (count <= gl->list_room)
        return OST_OK;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    if (room > (uint64_t)limit)
        return ost_fail(err, OST_ERR_RANGE, "OpenGL (%s) draws lists of up to %d voxels; here are more: --renderer points draws them",
                        gl->context.info.driver, (int)limit);
    free(gl->numbers);
    gl->list_room = 0;
    gl->numbers = malloc(room * sizeof *gl->numbers);
    if (!gl->numbers)
        return ost_fail(err, OST_ERR_MEMORY, "no memory to draw %llu voxels", (unsigned long long)count);
    glDeleteBuffers(1, &gl->list);
    glDeleteTextures(1, &gl->list_texture);
    gl->list = ost_gl_buffer_make(&gl->context, GL_COPY_WRITE_BUFFER, room * sizeof *gl->numbers, &gl->list_mapped);
    gl->list_texture = ost_gl_buffer_texture(gl->list, GL_R32UI);
    ost_status status = ost_gl_context_check(&gl->context, "makes room for a list", err);
    gl->list_room = status == OST_OK ? (uint32_t)room : 0;
    return status;
}

/* ---------------------------------------------------------------- choosing */

static int by_slot(const void *a, const void *b)
{
    return ((const ost_frame_block *)a)->slot - ((const ost_frame_block *)b)->slot;
}

static void choose_blocks(ost_gl *gl, const ost_gl_variant *v, layer *l)
{
    const ost_surface *s = l->thing->surface;
    ost_blocks_choose(s, &l->eye, gl->blocks, gl->bases, &l->blocks, &l->y0, &l->y1);
    if (!v->frustum) {
        l->blocks = 0;
        l->y0 = 0;
        l->y1 = l->thing->eye.height;
        for (int32_t i = 0; i < s->used; i++)
            if (s->slot[i]->count)
                gl->blocks[l->blocks++] = (ost_frame_block){.slot = i, .count = s->slot[i]->count};
    } else if (!v->order && l->blocks) {
        qsort(gl->blocks, (size_t)l->blocks, sizeof *gl->blocks, by_slot);
    }
}

/* Numbers of a block's points that have a face toward the eye. */
static uint32_t list_points(const ost_surface_block *b, const float base[3], uint32_t first, uint32_t *out)
{
    uint8_t turned[3][OST_BLOCK];
    uint32_t n = 0;
    for (int a = 0; a < 3; a++)
        ost_blocks_turned(base[a], a, turned[a]);
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t p = b->points[i], seen = (uint32_t)(turned[0][p & 31] | turned[1][p >> 5 & 31] | turned[2][p >> 10 & 31]);
        out[n] = first + i;
        n += (p >> OST_FACES_SHIFT & seen) != 0;
    }
    return n;
}

/* The most pixels that a voxel of the block may be wide: splat_scalar.c's slopes at the frame's corner. */
static float largest_voxel(const ost_splat_eye *s, const float base[3])
{
    const ost_eye *e = &s->eye;
    const float middle[3] = {base[0] + 15.5f, base[1] + 15.5f, base[2] + 15.5f};
    const float nearest = ost_eye_dot(e->forward, middle) - (float)OST_BLOCK * s->reach[2];
    const float slope = hypotf(e->half_w, e->half_h) / e->focal, wide = 1.7320508f * sqrtf(1 + slope * slope);
    return wide * e->focal / (nearest > e->near ? nearest : e->near) + 2;
}

static void list_blocks(ost_gl *gl, layer *l)
{
    const ost_surface *s = l->thing->surface;
    uint32_t n = gl->list_used;
    l->begin = n;
    l->near = 0;
    for (int32_t i = 0; i < l->blocks; i++) {
        const int32_t slot = gl->blocks[i].slot;
        n += list_points(s->slot[slot], gl->bases + 4 * slot, l->resident->run[OST_GL_POINTS][slot].first, gl->numbers + n);
        if (largest_voxel(&l->eye, gl->bases + 4 * slot) > gl->context.info.largest)
            l->near = n - l->begin;
    }
    l->count = n - l->begin;
    gl->list_used = n;
}

/* Where a voxel is less than this wide, a brick is the cheaper point. */
static const float SMALL_VOXEL = 3.0f;

static bool are_small(const ost_gl *gl, const layer *l)
{
    if (l->blocks == 0)
        return false;
    const float half = 27.8f; /* of a block's diagonal */
    const float nearest = sqrtf(gl->blocks[0].distance) - half;
    return nearest > 2 * OST_BLOCK && l->thing->eye.focal < SMALL_VOXEL * nearest;
}

/* ----------------------------------------------------------------- prepare */

static void copy3(float to[4], const float from[3], float w)
{
    memcpy(to, from, 3 * sizeof *to);
    to[3] = w;
}

/* Of what is drawn of the layer, the farthest distance squared, generously. */
static float farthest(const ost_gl *gl, const layer *l)
{
    float most = 1;
    for (int32_t i = 0; i < l->blocks; i++) {
        const float *base = gl->bases + 4 * gl->blocks[i].slot;
        float square = 0;
        for (int a = 0; a < 3; a++) {
            const float far = fmaxf(fabsf(base[a] - 1), fabsf(base[a] + (float)OST_BLOCK));
            square += far * far;
        }
        most = fmaxf(most, square);
    }
    return most;
}

static void put_eye(ost_gl *gl, int number, ost_style style)
{
    const layer *l = &gl->layer[number];
    const ost_eye *e = &l->thing->eye;
    const ost_paint *p = &l->thing->paint;
    const ost_pm s = l->thing->surface->geometry.spacing.x, first = gl->layer[0].thing->surface->geometry.spacing.x;
    eye_block b = {
        .frame = {(float)e->width, (float)e->height, 0x1p-32f, 0},
        .layer = {(float)((double)s / (double)first), style == OST_STYLE_FACES, OST_HALF_WIDE, 0},
        .paint = {p->red, p->green, p->blue, 0},
    };
    int exponent;
    frexpf(farthest(gl, l), &exponent);
    if (!gl->context.zero_to_one) {
        b.frame[2] = ldexpf(1, 1 - exponent);
        b.frame[3] = -1;
    }
    copy3(b.at, e->at, e->focal);
    copy3(b.right, e->right, l->eye.reach[0]);
    copy3(b.up, e->up, l->eye.reach[1]);
    copy3(b.forward, e->forward, l->eye.reach[2]);
    copy3(b.axis[0], l->eye.axis[0], e->half_w);
    copy3(b.axis[1], l->eye.axis[1], e->half_h);
    copy3(b.axis[2], l->eye.axis[2], e->near);
    ost_light_make(&gl->light, &gl->directions, e, style, *p, l->thing->palette);
    memcpy(b.light_0, gl->light.face, sizeof b.light_0);
    memcpy(b.light_4, gl->light.face + 4, 2 * sizeof *b.light_4);
    b.light_4[2] = OST_BACKGROUND;
    for (int i = 0; i < OST_OCTAHEDRAL_COUNT; i++)
        gl->palette[i] = gl->light.shade[i];
    memcpy(gl->palette + OST_OCTAHEDRAL_COUNT, gl->light.colour, sizeof gl->light.colour);
    glBindBuffer(GL_UNIFORM_BUFFER, gl->eyes);
    glBufferSubData(GL_UNIFORM_BUFFER, (GLintptr)number * gl->eye_stride, sizeof b, &b);
    glBindBuffer(GL_TEXTURE_BUFFER, l->palette);
    glBufferSubData(GL_TEXTURE_BUFFER, 0, sizeof gl->palette, gl->palette);
}

/* ----------------------------------------------------------------- drawing */

static void bind(ost_gl_unit unit, GLenum target, GLuint texture)
{
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(target, texture);
}

static void bind_layer(ost_gl *gl, int number, ost_gl_form form)
{
    bind(OST_GL_UNIT_PAGES, GL_TEXTURE_BUFFER, ost_gl_store_pool(&gl->store, form)->page_texture);
    bind(OST_GL_UNIT_PALETTE, GL_TEXTURE_BUFFER, gl->layer[number].palette_texture);
    bind(OST_GL_UNIT_POINTS, GL_TEXTURE_BUFFER, gl->store.points.texture);
    bind(OST_GL_UNIT_LOOKS, GL_TEXTURE_BUFFER, gl->store.looks.texture);
    bind(OST_GL_UNIT_LIST, GL_TEXTURE_BUFFER, gl->list_texture);
    glBindBufferRange(GL_UNIFORM_BUFFER, OST_GL_EYE, gl->eyes, (GLintptr)number * gl->eye_stride, sizeof(eye_block));
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

/* All of the chosen blocks. */
static void draw_runs(ost_gl *gl, const layer *l)
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

static ost_status draw_mesh(ost_gl *gl, const layer *l, ost_gl_target target, ost_error *err)
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

static ost_status draw_points(ost_gl *gl, const ost_gl_variant *v, layer *l, ost_error *err)
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
    if (l->mesh)
        return draw_mesh(gl, l, v->target, err);
    const bool listed = l->form == OST_GL_POINTS && v->facing;
    if (listed && l->near && v->tight) {
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
    if (!listed) {
        draw_runs(gl, l);
        return OST_OK;
    }
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, gl->list);
    glDrawElements(GL_POINTS, (GLsizei)(l->count - l->near), GL_UNSIGNED_INT, (const void *)((l->begin + l->near) * sizeof(uint32_t)));
    gl->did.points += l->count;
    return OST_OK;
}

static void clear_gbuffer(ost_gl_target kind)
{
    static const GLuint none[4] = {OST_NO_FACE << 24, 0x3f800000 /* 1.0f */, 0, 0};
    static const GLfloat nothing[4] = {0, 0, 0, 0}, back[4] = {0x16 / 255.0f, 0x18 / 255.0f, 0x1c / 255.0f, 6 / 255.0f}, far = 1;
    _Static_assert(OST_BACKGROUND == 0x1c1816, "the colour that a forward frame is cleared to");
    if (kind == OST_GL_COMPACT)
        glClearBufferuiv(GL_COLOR, 0, none);
    else
        glClearBufferfv(GL_COLOR, 0, kind == OST_GL_FORWARD ? back : nothing);
    if (kind == OST_GL_WIDE || kind == OST_GL_SMALL)
        glClearBufferfv(GL_COLOR, 1, nothing);
    glClearBufferfv(GL_DEPTH, 0, &far);
}

static ost_status composite(ost_gl *gl, const ost_gl_program_key *key, bool first, ost_error *err)
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

/* A layer by itself, then of each pixel what is nearer. */
static ost_status draw_layer(ost_gl *gl, const ost_gl_variant *v, int number, ost_error *err)
{
    layer *l = &gl->layer[number];
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_COMPOSITE, .first = number == 0};
    if (number > 0 && l->y0 >= l->y1)
        return OST_OK;
    if (number > 0) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, l->y0, gl->targets.width, l->y1 - l->y0);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, gl->targets.gbuffer);
    clear_gbuffer(v->target);
    bind_layer(gl, number, l->form);
    glDepthFunc(GL_LESS);
    ost_status status = l->blocks ? draw_points(gl, v, l, err) : OST_OK;
    if (status == OST_OK)
        status = composite(gl, &key, number == 0, err);
    glDisable(GL_SCISSOR_TEST);
    return status;
}

/* All layers into one G-buffer, which has their depth; or the only one into the picture. */
static ost_status draw_together(ost_gl *gl, const ost_gl_variant *v, int count, ost_error *err)
{
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_WIDE, .target = v->target};
    ost_status status = OST_OK;
    glBindFramebuffer(GL_FRAMEBUFFER, v->target == OST_GL_FORWARD ? gl->targets.picture : gl->targets.gbuffer);
    clear_gbuffer(v->target);
    glDepthFunc(GL_LESS);
    for (int i = 0; i < count && status == OST_OK; i++) {
        layer *l = &gl->layer[i];
        choose_blocks(gl, v, l);
        bind_layer(gl, i, l->form);
        status = l->blocks ? draw_points(gl, v, l, err) : OST_OK;
    }
    bind_layer(gl, 0, gl->layer[0].form);
    return status == OST_OK && v->target != OST_GL_FORWARD ? composite(gl, &key, true, err) : status;
}

static void set_state(const ost_gl *gl)
{
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glViewport(0, 0, gl->targets.width, gl->targets.height);
    glBindVertexArray(gl->vertices);
    if (gl->context.zero_to_one)
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

/* ------------------------------------------------------------------- frame */

static ost_status prepare(ost_gl *gl, const ost_gl_variant *v, int number, ost_error *err)
{
    layer *l = &gl->layer[number];
    const ost_surface *s = l->thing->surface;
    ost_status status = ost_blocks_check(s, &l->thing->eye, err);
    if (status == OST_OK)
        status = room_for_blocks(gl, s->used, err);
    if (status != OST_OK)
        return status;
    l->eye = ost_splat_prepare(&l->thing->eye);
    choose_blocks(gl, v, l);
    l->mesh = v->every_voxel && number > 0;
    l->form = v->every_voxel ? OST_GL_VOXELS : v->bricks || (v->choose && are_small(gl, l)) ? OST_GL_BRICKS : OST_GL_POINTS;
    gl->did.bricks = number == 0 ? l->form == OST_GL_BRICKS : gl->did.bricks;
    return l->mesh ? ost_gl_store_bring_mesh(&gl->context, &gl->store, s, &l->resident, err)
                   : ost_gl_store_bring(&gl->context, &gl->store, s, l->form, &l->resident, err);
}

/* The list of one layer after the other; blocks hold those of the last one prepared. */
static ost_status draw_all(ost_gl *gl, const ost_gl_variant *v, int count, ost_style style, ost_error *err)
{
    uint64_t points = 0;
    ost_status status = OST_OK;
    for (int i = 0; i < count; i++)
        points += gl->layer[i].thing->surface->points;
    if (v->facing)
        status = room_for_list(gl, points + 1, err);
    gl->list_used = 0;
    const bool together = v->target != OST_GL_COMPACT;
    for (int i = 0; i < count && status == OST_OK; i++) {
        layer *l = &gl->layer[i];
        choose_blocks(gl, v, l);
        if (l->form == OST_GL_POINTS && v->facing) {
            list_blocks(gl, l);
            if (gl->list_mapped) {
                memcpy((uint32_t *)gl->list_mapped + l->begin, gl->numbers + l->begin, l->count * sizeof *gl->numbers);
            } else if (l->count) {
                glBindBuffer(GL_COPY_WRITE_BUFFER, gl->list);
                glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)(l->begin * sizeof *gl->numbers), (GLsizeiptr)(l->count * sizeof *gl->numbers),
                                gl->numbers + l->begin);
            }
        }
        put_eye(gl, i, style);
        if (!together)
            status = draw_layer(gl, v, i, err);
    }
    return status == OST_OK && together ? draw_together(gl, v, count, err) : status;
}

static ost_status draw(ost_gl *gl, const ost_gl_variant *v, const ost_frame_thing *things, int count, ost_style style, ost_error *err)
{
    const ost_eye *e = &things[0].eye;
    gl->did = (ost_gl_counts){0};
    gl->store.frame++;
    gl->store.uploaded = 0;
    ost_status status = wait_for_last(gl, err);
    if (status == OST_OK)
        status = ost_gl_targets_make(&gl->context, &gl->targets, e->width, e->height, v->target, err);
    for (int i = 0; i < count && status == OST_OK; i++) {
        gl->layer[i].thing = &things[i];
        status = prepare(gl, v, i, err);
    }
    if (status != OST_OK)
        return status;
    set_state(gl);
    status = draw_all(gl, v, count, style, err);
    gl->did.uploaded = gl->store.uploaded;
    const ost_status after = ost_gl_context_check(&gl->context, "draws", status == OST_OK ? err : NULL);
    status = status == OST_OK ? after : status;
    if (status == OST_OK)
        gl->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    return status;
}

typedef struct drawing {
    ost_gl *gl;
    const ost_gl_variant *variant;
    const ost_frame_thing *things;
    int count;
    ost_style style;
} drawing;

static ost_status draw_here(void *user, ost_error *err)
{
    const drawing *d = user;
    return draw(d->gl, d->variant, d->things, d->count, d->style, err);
}

ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count, ost_style style, ost_error *err)
{
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d things to draw; 1 to %d are supported", count, OST_FRAME_LAYERS);
    if (count > 1 && (variant->target == OST_GL_FORWARD || (variant->target != OST_GL_COMPACT && !variant->true_depth)))
        return ost_fail(err, OST_ERR_USAGE, "this way of drawing has no depth to tell %d things apart", count);
    return ost_gl_worker_do(gl->worker, draw_here, &(drawing){gl, variant, things, count, variant->every_voxel ? OST_STYLE_FACES : style}, err);
}

static ost_status finish_here(void *user, ost_error *err)
{
    ost_gl *gl = user;
    glFinish();
    return ost_gl_context_check(&gl->context, "ends a frame", err);
}

ost_status ost_gl_finish(ost_gl *gl, ost_error *err)
{
    return ost_gl_worker_do(gl->worker, finish_here, gl, err);
}

static ost_status read_planes(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err)
{
    const ost_planes *p = &frame->planes;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, gl->targets.picture);
    glPixelStorei(GL_PACK_ROW_LENGTH, p->stride);
    glReadPixels(0, 0, frame->width, frame->height, GL_RGBA, GL_UNSIGNED_BYTE, p->colour);
    if (depth)
        glReadPixels(0, 0, frame->width, frame->height, GL_DEPTH_COMPONENT, GL_FLOAT, p->depth);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    ost_status status = ost_gl_context_check(&gl->context, "reads a frame", err);
    for (int y = 0; y < frame->height; y++) {
        const size_t at = (size_t)y * (size_t)p->stride;
        for (size_t i = at; i < at + (size_t)frame->width; i++) {
            p->face[i] = (uint8_t)(p->colour[i] >> 24);
            p->colour[i] &= 0xffffff;
            if (depth)
                p->depth[i] *= 65536; /* eye.glsl's DEPTH_SCALE */
        }
    }
    return status;
}

typedef struct reading {
    ost_gl *gl;
    ost_frame *frame;
    bool depth;
} reading;

static ost_status read_here(void *user, ost_error *err)
{
    const reading *r = user;
    return read_planes(r->gl, r->frame, r->depth, err);
}

ost_status ost_gl_read(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err)
{
    if (frame->width != gl->targets.width || frame->height != gl->targets.height)
        return ost_fail(err, OST_ERR_USAGE, "a frame of %d x %d pixels is not the picture's %d x %d", frame->width, frame->height, gl->targets.width,
                        gl->targets.height);
    return ost_gl_worker_do(gl->worker, read_here, &(reading){gl, frame, depth}, err);
}
