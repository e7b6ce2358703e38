/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A buffer of OpenGL that many blocks share, each with a run of granules.
 *
 *   | block 7 . . | block 2 | free | block 0 . . . |      a granule: 2^bits elements
 *   | page | page | page    |      | page | page   |      a page: where the granule's block begins, in voxels
 *
 * A vertex finds its block by its number: page = number >> bits.  The buffer
 * stays mapped where that can be (4.4), and is written from there; else by
 * glBufferSubData.  Nothing may be written that a frame still reads: whoever
 * writes has waited for the last one.
 */
#ifndef OST_RENDER_GL_POOL_H
#define OST_RENDER_GL_POOL_H

#include "render/gl/context.h"

typedef struct ost_gl_pool {
    const char *what;    /* of its elements, for messages */
    size_t element;      /* bytes */
    unsigned bits;
    GLenum format;       /* of its texture; 0: none */
    uint32_t granules, next; /* next: where the search for room begins */
    uint8_t *used;       /* owned; a granule each */
    GLuint buffer, texture, page_buffer, page_texture;
    void *mapped, *page_mapped;
} ost_gl_pool;

/* Nothing is made before there is something to hold. format: of the texture that shaders read it by, 0: none. */
void ost_gl_pool_init(ost_gl_pool *pool, const char *what, size_t element, unsigned bits, GLenum format);
void ost_gl_pool_free(ost_gl_pool *pool); /* also of a zeroed one */

/* The first element of a run with room for count, and the number of its granules. */
ost_status ost_gl_pool_take(ost_gl_context *context, ost_gl_pool *pool, uint32_t count, uint32_t *first, uint32_t *granules, ost_error *err);
void ost_gl_pool_give(ost_gl_pool *pool, uint32_t first, uint32_t granules);
void ost_gl_pool_write(const ost_gl_pool *pool, uint32_t first, const void *data, uint32_t count);
/* Of a run: the block's first voxel. */
void ost_gl_pool_place(const ost_gl_pool *pool, uint32_t first, uint32_t granules, const int32_t voxel[3]);

/* A buffer of so many bytes that the processor writes, mapped where that can be; *mapped NULL where not. */
GLuint ost_gl_buffer_make(const ost_gl_context *context, GLenum target, size_t bytes, void **mapped);
/* A texture by which shaders read a buffer. */
GLuint ost_gl_buffer_texture(GLuint buffer, GLenum format);

#endif
