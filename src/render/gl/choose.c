/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/gl/choose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ost_status ost_gl_reserve_blocks(ost_gl *gl, int32_t count, ost_error *err)
{
    if (count <= gl->block_capacity)
        return OST_OK;
    free(gl->blocks);
    free(gl->bases);
    free(gl->firsts);
    free(gl->counts);
    free(gl->wanted);
    free(gl->offsets);
    gl->blocks = malloc((size_t)count * sizeof *gl->blocks);
    gl->bases = malloc((size_t)count * 4 * sizeof *gl->bases);
    gl->firsts = malloc((size_t)count * sizeof *gl->firsts);
    gl->counts = malloc((size_t)count * sizeof *gl->counts);
    gl->wanted = malloc((size_t)count * sizeof *gl->wanted);
    gl->offsets = calloc((size_t)count, sizeof *gl->offsets);
    gl->block_capacity = gl->blocks && gl->bases && gl->firsts && gl->counts && gl->wanted && gl->offsets ? count : 0;
    return gl->block_capacity ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for drawing %d blocks",
                                                  (int)count);
}

ost_status ost_gl_reserve_list(ost_gl *gl, uint64_t count, ost_error *err)
{
    GLint limit = 0;
    const uint64_t capacity = count + count / 4 + 1024;
    if (count <= gl->list_capacity)
        return OST_OK;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    if (capacity > (uint64_t)limit)
        return ost_fail(err, OST_ERR_RANGE, "OpenGL (%s) draws at most %d voxels; use --renderer points",
                        gl->context.info.driver, (int)limit);
    free(gl->numbers);
    gl->list_capacity = 0;
    gl->numbers = malloc(capacity * sizeof *gl->numbers);
    if (!gl->numbers)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for drawing %llu voxels", (unsigned long long)count);
    glDeleteBuffers(1, &gl->list);
    glDeleteTextures(1, &gl->list_texture);
    gl->list = ost_gl_buffer_make(&gl->context, GL_COPY_WRITE_BUFFER, capacity * sizeof *gl->numbers, &gl->list_mapped);
    gl->list_texture = ost_gl_buffer_texture(gl->list, GL_R32UI);
    ost_status status = ost_gl_context_check(&gl->context, "makes room for a list", err);
    gl->list_capacity = status == OST_OK ? (uint32_t)capacity : 0;
    return status;
}

static int by_slot(const void *a, const void *b)
{
    return ((const ost_frame_block *)a)->slot - ((const ost_frame_block *)b)->slot;
}

void ost_gl_choose_blocks(ost_gl *gl, const ost_gl_variant *v, ost_gl_layer *l)
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
    if (v->slots > 0) {
        int32_t n = 0;
        for (int32_t i = 0; i < l->blocks; i++)
            if (gl->blocks[i].slot < v->slots)
                gl->blocks[n++] = gl->blocks[i];
        l->blocks = n;
    }
    for (int32_t i = 0; i < l->blocks; i++)
        gl->wanted[i] = UINT64_MAX;
}

/*
 * Lists the points of the block that are in one of the `wanted` cells and have a face toward the eye. Writes the
 * numbers of these points to out[], and returns their count.
 */
static uint32_t list_points(const ost_surface_block *b, const float base[3], uint64_t wanted, uint32_t first,
                            uint32_t *out)
{
    uint8_t turned[3][OST_BLOCK];
    uint32_t n = 0;
    for (int a = 0; a < 3; a++)
        ost_blocks_turned(base[a], a, turned[a]);
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t p = b->points[i],
                       seen = (uint32_t)(turned[0][p & 31] | turned[1][p >> 5 & 31] | turned[2][p >> 10 & 31]);
        const uint32_t cell = (p >> 3 & 3) | (p >> 6 & 12) | (p >> 9 & 48);
        out[n] = first + i;
        n += (p >> OST_FACES_SHIFT & seen) != 0 && (wanted >> cell & 1);
    }
    return n;
}

/* Lists the bricks of the block that are in one of the `wanted` cells. Writes their numbers to out[], and returns their
   count. The number of a brick is its rank among the set bits of run->bricks, plus run->first. */
static uint32_t list_bricks(const ost_gl_run *run, uint64_t wanted, uint32_t *out)
{
    uint32_t n = 0, number = run->first;
    for (uint32_t z = 0; z < 8; z++)
        for (uint64_t left = run->bricks[z]; left; left &= left - 1) {
            out[n] = number++;
            n += wanted >> ost_gl_cell_of_brick(z << 6 | (uint32_t)__builtin_ctzll(left)) & 1;
        }
    return n;
}

/* Returns an upper bound on the width in pixels of any voxel of the block. The width grows with the slope of the ray
 * (splat_scalar.c), which is greatest at a corner of the frame. */
static float largest_voxel(const ost_splat_eye *s, const float base[3])
{
    const ost_eye *e = &s->eye;
    const float middle[3] = {base[0] + 15.5f, base[1] + 15.5f, base[2] + 15.5f};
    const float nearest = ost_eye_dot(e->forward, middle) - (float)OST_BLOCK * s->reach[2];
    /* In the frame of a headset's eye, the forward axis does not pass through the middle. */
    const float farther_w = fmaxf(e->half_w, (float)e->width - e->half_w),
                farther_h = fmaxf(e->half_h, (float)e->height - e->half_h);
    const float slope = hypotf(farther_w, farther_h) / e->focal, wide = 1.7320508f * sqrtf(1 + slope * slope);
    return wide * e->focal / (nearest > e->near ? nearest : e->near) + 2;
}

void ost_gl_list_blocks(ost_gl *gl, ost_gl_layer *l)
{
    const ost_surface *s = l->thing->surface;
    uint32_t n = gl->list_used;
    l->begin = n;
    l->near = 0;
    for (int32_t i = 0; i < l->blocks; i++) {
        const int32_t slot = gl->blocks[i].slot;
        const ost_gl_run *run = &l->resident->run[l->form][slot];
        if (!(gl->wanted[i] & run->cells))
            continue;
        if (l->form == OST_GL_BRICKS) {
            n += list_bricks(run, gl->wanted[i], gl->numbers + n);
            continue;
        }
        n += list_points(s->slot[slot], gl->bases + 4 * slot, gl->wanted[i], run->first, gl->numbers + n);
        if (largest_voxel(&l->eye, gl->bases + 4 * slot) > gl->context.info.largest)
            l->near = n - l->begin;
    }
    l->count = n - l->begin;
    gl->list_used = n;
    if (gl->list_mapped) {
        memcpy((uint32_t *)gl->list_mapped + l->begin, gl->numbers + l->begin, l->count * sizeof *gl->numbers);
    } else if (l->count) {
        glBindBuffer(GL_COPY_WRITE_BUFFER, gl->list);
        glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)(l->begin * sizeof *gl->numbers),
                        (GLsizeiptr)(l->count * sizeof *gl->numbers), gl->numbers + l->begin);
    }
}

/* voxels that appear narrower than this number of pixels are drawn faster as bricks than as points */
static const float SMALL_VOXEL = 3.0f;

bool ost_gl_are_small(const ost_gl *gl, const ost_gl_layer *l)
{
    if (l->blocks == 0)
        return false;
    const float half = 27.8f; /* half of a block's diagonal, in voxels */
    const float nearest = sqrtf(gl->blocks[0].distance) - half;
    return nearest > 2 * OST_BLOCK && l->thing->eye.focal < SMALL_VOXEL * nearest;
}
