/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a frame with OpenGL, object by object:
 *
 *   changed blocks --> pools          (resident.c)
 *   blocks in view, near first        (points/blocks.h)
 *   points that face the eye          --> list of vertices (choose.c)
 *   G-buffer cleared, points drawn, composited over the picture (pass.c)
 *       the points are drawn in two parts, between which hidden cells are found (hide.c)
 *
 * The depth of a pixel is the squared distance from the eye to the voxel's centre. If clip-space depth ranges from 0 to
 * 1 (OpenGL 4.5), the distance is stored exactly: the stored float is a power of two times the float that the CPU
 * renderer compares. In older versions, the distance is rounded to a 24-bit fraction of the maximum distance.
 */
#include "core/conditions.h"
#include "render/gl/insides.h"

#include <stdlib.h>
#include <string.h>

#include "render/gl/choose.h"
#include "render/gl/eye.h"
#include "render/gl/hide.h"
#include "render/gl/pass.h"
#include "render/gl/smooth.h"

const ost_gl_variant ost_gl_ours = {
    .frustum = true, .facing = true, .order = true, .occlusion = true, .tight = true, .lines = true, .choose = true};
const ost_gl_variant ost_gl_mesh = {.frustum = true, .order = true, .mesh = true};
const ost_gl_variant ost_gl_thesis = {.every_voxel = true, .true_depth = true, .target = OST_GL_WIDE};

/* ------------------------------------------------------------- open, close */

static ost_status make(ost_gl *gl, ost_error *err)
{
    GLint alignment = 1;
    ost_directions_make(&gl->directions);
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    gl->eye_stride = ((GLint)sizeof(ost_gl_eye_block) + alignment - 1) / alignment * alignment;
    glGenVertexArrays(1, &gl->vertices);
    glGenBuffers(1, &gl->eyes);
    glBindBuffer(GL_UNIFORM_BUFFER, gl->eyes);
    glBufferData(GL_UNIFORM_BUFFER, (GLsizeiptr)gl->eye_stride * OST_FRAME_LAYERS, NULL, GL_STREAM_DRAW);
    for (int i = 0; i < OST_FRAME_LAYERS; i++) {
        ost_gl_layer *l = &gl->layer[i];
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
    o->gl->open = status == OST_OK;
    return status == OST_OK ? make(o->gl, err) : status;
}

static ost_status close_here(void *user, ost_error *err)
{
    ost_gl *gl = user;
    (void)err;
    if (!gl->open)
        return OST_OK;
    if (gl->fence)
        glDeleteSync(gl->fence);
    for (int i = 0; i < OST_FRAME_LAYERS; i++) {
        glDeleteBuffers(1, &gl->layer[i].palette);
        glDeleteTextures(1, &gl->layer[i].palette_texture);
    }
    ost_gl_smooth_free(gl);
    glDeleteBuffers(1, &gl->list);
    glDeleteTextures(1, &gl->list_texture);
    glDeleteBuffers(1, &gl->quad_indices);
    glDeleteTextures(1, &gl->sheet);
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
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a renderer");
    gl->context.context = EGL_NO_CONTEXT;
    ost_gl_store_init(&gl->store);
    ost_status status = o.current ? OST_OK : ost_gl_worker_start(&gl->worker, err);
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
    ost_gl_worker_do(gl->worker, close_here, gl, NULL);
    ost_gl_worker_stop(gl->worker);
    ost_gl_abandon(gl);
}

void ost_gl_abandon(ost_gl *gl)
{
    if (!gl)
        return;
    ost_gl_targets_abandon(&gl->targets);
    ost_gl_store_abandon(&gl->store);
    free(gl->numbers);
    free(gl->blocks);
    free(gl->bases);
    free(gl->firsts);
    free(gl->counts);
    free(gl->wanted);
    free(gl->offsets);
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

void ost_gl_set_mesher(ost_gl *gl, ost_backend *mesher)
{
    gl->store.mesher = mesher;
}

/* Waits until OpenGL has completed the last frame. Only then may the data of that frame be overwritten. */
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

/* ------------------------------------------------------------------ layers */

/*
 * Draws the cells that may be visible but were not drawn in the first part, because they were hidden in the last frame.
 */
static ost_status draw_missing(ost_gl *gl, const ost_gl_variant *v, int number, ost_error *err)
{
    ost_gl_layer *l = &gl->layer[number];
    bool missing = false;
    ost_status status = ost_gl_hide_test(gl, v, l, &missing, err);
    ost_gl_set_state(gl);
    if (status != OST_OK || !missing)
        return status;
    ost_gl_list_blocks(gl, l);
    glBindFramebuffer(GL_FRAMEBUFFER, gl->targets.gbuffer);
    ost_gl_bind_layer(gl, number, l->form);
    return ost_gl_draw_points(gl, v, l, err);
}

/* Draws a layer into the G-buffer, and composites it over the picture in the pixels where the layer is nearer. */
static ost_status draw_layer(ost_gl *gl, const ost_gl_variant *v, int number, ost_error *err)
{
    ost_gl_layer *l = &gl->layer[number];
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_COMPOSITE, .first = number == 0};
    if (l->smooth)
        return ost_gl_smooth_draw(gl, number, err);
    if (number > 0 && l->y0 >= l->y1)
        return OST_OK;
    if (number > 0) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, l->y0, gl->targets.width, l->y1 - l->y0);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, gl->targets.gbuffer);
    ost_gl_clear_gbuffer(v->target);
    ost_gl_bind_layer(gl, number, l->form);
    glDepthFunc(GL_LESS);
    ost_status status = l->blocks ? ost_gl_draw_points(gl, v, l, err) : OST_OK;
    if (status == OST_OK && ost_gl_hide_wanted(v, l, number))
        status = draw_missing(gl, v, number, err);
    if (status == OST_OK)
        status = ost_gl_composite(gl, &key, number == 0, err);
    glDisable(GL_SCISSOR_TEST);
    return status;
}

/*
 * Draws all layers with one depth buffer. Draws into the G-buffer or, with OST_GL_FORWARD, directly into the picture.
 */
static ost_status draw_together(ost_gl *gl, const ost_gl_variant *v, int count, ost_error *err)
{
    const ost_gl_program_key key = {.stage = OST_GL_STAGE_WIDE, .target = v->target};
    ost_status status = OST_OK;
    glBindFramebuffer(GL_FRAMEBUFFER, v->target == OST_GL_FORWARD ? gl->targets.picture : gl->targets.gbuffer);
    ost_gl_clear_gbuffer(v->target);
    glDepthFunc(GL_LESS);
    for (int i = 0; i < count && status == OST_OK; i++) {
        ost_gl_layer *l = &gl->layer[i];
        ost_gl_choose_blocks(gl, v, l);
        ost_gl_bind_layer(gl, i, l->form);
        status = l->blocks ? ost_gl_draw_points(gl, v, l, err) : OST_OK;
    }
    ost_gl_bind_layer(gl, 0, gl->layer[0].form);
    return status == OST_OK && v->target != OST_GL_FORWARD ? ost_gl_composite(gl, &key, true, err) : status;
}

/* ------------------------------------------------------------------- frame */

static ost_status prepare(ost_gl *gl, const ost_gl_variant *v, int number, ost_error *err)
{
    ost_gl_layer *l = &gl->layer[number];
    const ost_surface *s = l->thing->surface;
    ost_status status = ost_blocks_check(s, &l->thing->eye, err);
    if (status == OST_OK)
        status = ost_gl_reserve_blocks(gl, s->used, err);
    if (status != OST_OK)
        return status;
    l->eye = ost_splat_prepare(&l->thing->eye);
    ost_gl_choose_blocks(gl, v, l);
    l->smooth = l->thing->mesh && v->target == OST_GL_COMPACT;
    l->mesh = v->every_voxel && number > 0;
    l->form = v->mesh                                               ? OST_GL_QUADS
              : v->every_voxel                                      ? OST_GL_VOXELS
              : v->bricks || (v->choose && ost_gl_are_small(gl, l)) ? OST_GL_BRICKS
                                                                    : OST_GL_POINTS;
    gl->did.bricks = number == 0 ? l->form == OST_GL_BRICKS : gl->did.bricks;
    if (l->smooth)
        return OST_OK;
    if (v->mesh)
        return ost_gl_store_bring_quads(&gl->context, &gl->store, s, &l->resident, err);
    return l->mesh ? ost_gl_store_bring_mesh(&gl->context, &gl->store, s, &l->resident, err)
                   : ost_gl_store_bring(&gl->context, &gl->store, s, l->form, &l->resident, err);
}

/* Builds the lists of the layers and draws the layers, one by one or together. */
static ost_status draw_all(ost_gl *gl, const ost_gl_variant *v, int count, ost_style style, ost_error *err)
{
    uint64_t points = 0;
    ost_status status = OST_OK;
    for (int i = 0; i < count; i++)
        points += gl->layer[i].thing->surface->points;
    if (v->facing || v->occlusion)
        status = ost_gl_reserve_list(gl, points + 1, err);
    gl->list_used = 0;
    const bool together = v->target != OST_GL_COMPACT;
    for (int i = 0; i < count && status == OST_OK; i++) {
        ost_gl_layer *l = &gl->layer[i];
        ost_gl_choose_blocks(gl, v, l);
        const bool hide = !l->smooth && ost_gl_hide_wanted(v, l, i);
        l->listed = !l->smooth && (hide || (l->form == OST_GL_POINTS && v->facing));
        if (hide)
            ost_gl_hide_guess(gl, l);
        if (l->listed)
            ost_gl_list_blocks(gl, l);
        ost_gl_put_eye(gl, i, style);
        if (!together)
            status = draw_layer(gl, v, i, err);
    }
    return status == OST_OK && together ? draw_together(gl, v, count, err) : status;
}

static ost_status draw(ost_gl *gl, const ost_gl_variant *v, const ost_frame_thing *things, int count, ost_style style,
                       ost_error *err)
{
    const ost_eye *e = &things[0].eye;
    gl->did = (ost_gl_counts){0};
    gl->store.frame++;
    gl->store.uploaded = 0;
    gl->store.meshed = 0;
    gl->store.mesh_ns = gl->store.copy_ns = 0;
    ost_status status = wait_for_last(gl, err);
    if (status == OST_OK)
        status = ost_gl_targets_make(&gl->context, &gl->targets, e->width, e->height, v->target, err);
    for (int i = 0; i < count && status == OST_OK; i++) {
        gl->layer[i].thing = &things[i];
        status = prepare(gl, v, i, err);
    }
    if (status != OST_OK)
        return status;
    ost_gl_set_state(gl);
    status = draw_all(gl, v, count, style, err);
    gl->did.uploaded = gl->store.uploaded;
    gl->did.meshed = gl->store.meshed;
    gl->did.mesh_ns = gl->store.mesh_ns;
    gl->did.copy_ns = gl->store.copy_ns;
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

ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count,
                       ost_style style, ost_error *err)
{
    if (count < 1 || count > OST_FRAME_LAYERS)
        return ost_fail(err, OST_ERR_USAGE, "%d objects to draw; expected 1 to %d", count, OST_FRAME_LAYERS);
    if (count > 1 && (variant->target == OST_GL_FORWARD || (variant->target != OST_GL_COMPACT && !variant->true_depth)))
        return ost_fail(err, OST_ERR_USAGE, "this renderer has no depth buffer for %d objects", count);
    return ost_gl_worker_do(gl->worker, draw_here,
                            &(drawing){gl, variant, things, count, variant->every_voxel ? OST_STYLE_FACES : style},
                            err);
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
    const ost_planes *p = &frame->drawn;
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
                p->depth[i] *= 65536; /* undoes DEPTH_SCALE of eye.glsl */
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
        return ost_fail(err, OST_ERR_USAGE, "a frame of %d x %d pixels is not the picture's %d x %d", frame->width,
                        frame->height, gl->targets.width, gl->targets.height);
    return ost_gl_worker_do(gl->worker, read_here, &(reading){gl, frame, depth}, err);
}
