/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An OpenGL buffer that many blocks share. It is allocated in granules of 2^bits elements, and each block has a run of
 * consecutive granules.
 *
 *   | block 7 . . | block 2 | free | block 0 . . . |      granules
 *   | page | page | page    |      | page | page   |      page: position of the granule's block in voxels
 *
 * A vertex shader finds the position of vertex v's block in page v >> bits. With OpenGL 4.4, the buffer stays mapped
 * and is written through the mapping; in older versions, it is written with glBufferSubData. OpenGL may still read the
 * buffer to draw the last frame, so callers must wait for that frame before they write.
 */
#ifndef OST_RENDER_GL_POOL_H
#define OST_RENDER_GL_POOL_H

#include "render/gl/context.h"

typedef struct ost_gl_pool {
    const char *what;    /* name of the elements in messages */
    size_t element;      /* size of an element in bytes */
    unsigned bits;
    GLenum format;       /* format of the texture; 0 if there is no texture */
    /* granules: number of granules; next: granule at which the next search for a free run begins */
    uint32_t granules, next;
    uint8_t *used;       /* owned; for each granule, whether it is in use */
    GLuint buffer, texture, page_buffer, page_texture;
    void *mapped, *page_mapped;
} ost_gl_pool;

/*
 * Initializes an empty pool. OpenGL objects are created by the first call of ost_gl_pool_take. Shaders read the buffer
 * through a texture of the given format; 0 means no texture.
 */
void ost_gl_pool_init(ost_gl_pool *pool, const char *what, size_t element, unsigned bits, GLenum format);
/* Frees the pool's memory and OpenGL objects. Accepts a zero-initialized pool. */
void ost_gl_pool_free(ost_gl_pool *pool);
/* Frees only the pool's memory, without calling OpenGL. */
void ost_gl_pool_abandon(ost_gl_pool *pool);

/* Reserves a run of granules for `count` elements. Stores the index of the first element and the number of granules. */
ost_status ost_gl_pool_take(ost_gl_context *context, ost_gl_pool *pool, uint32_t count, uint32_t *first,
                            uint32_t *granules, ost_error *err);
void ost_gl_pool_give(ost_gl_pool *pool, uint32_t first, uint32_t granules);
void ost_gl_pool_write(const ost_gl_pool *pool, uint32_t first, const void *data, uint32_t count);
/*
 * Stores four numbers for the shaders in all pages of a block's run: the position of the block's first voxel, and the
 * argument `more`.
 */
void ost_gl_pool_place(const ost_gl_pool *pool, uint32_t first, uint32_t granules, const int32_t voxel[3],
                       int32_t more);

/* Creates a buffer that the CPU writes. Sets *mapped to its mapping, or to NULL if OpenGL does not support
   persistent mappings. */
GLuint ost_gl_buffer_make(const ost_gl_context *context, GLenum target, size_t bytes, void **mapped);
/* Creates a texture through which shaders read a buffer. */
GLuint ost_gl_buffer_texture(GLuint buffer, GLenum format);

#endif
