/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/pool.h"

#include <stdlib.h>
#include <string.h>

enum { LEAST = 64 }; /* capacity of the first buffer in granules */

GLuint ost_gl_buffer_make(const ost_gl_context *context, GLenum target, size_t bytes, void **mapped)
{
    GLuint buffer = 0;
    glGenBuffers(1, &buffer);
    glBindBuffer(target, buffer);
    *mapped = NULL;
    if (context->persistent) {
        const GLbitfield how = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
        glBufferStorage(target, (GLsizeiptr)bytes, NULL, how);
        *mapped = glMapBufferRange(target, 0, (GLsizeiptr)bytes, how);
    } else {
        glBufferData(target, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_DRAW);
    }
    return buffer;
}

GLuint ost_gl_buffer_texture(GLuint buffer, GLenum format)
{
    GLuint texture = 0;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_BUFFER, texture);
    glTexBuffer(GL_TEXTURE_BUFFER, format, buffer);
    return texture;
}

void ost_gl_pool_init(ost_gl_pool *pool, const char *what, size_t element, unsigned bits, GLenum format)
{
    *pool = (ost_gl_pool){.what = what, .element = element, .bits = bits, .format = format};
}

static void free_buffers(ost_gl_pool *p)
{
    const GLuint buffers[2] = {p->buffer, p->page_buffer}, textures[2] = {p->texture, p->page_texture};
    /* Deleting a buffer also unmaps it. glDeleteBuffers ignores 0. */
    if (p->buffer || p->page_buffer)
        glDeleteBuffers(2, buffers);
    if (p->texture || p->page_texture)
        glDeleteTextures(2, textures);
}

void ost_gl_pool_free(ost_gl_pool *pool)
{
    free_buffers(pool);
    ost_gl_pool_abandon(pool);
}

void ost_gl_pool_abandon(ost_gl_pool *pool)
{
    free(pool->used);
    *pool = (ost_gl_pool){0};
}

static size_t bytes_of(const ost_gl_pool *p, uint32_t granules)
{
    return ((size_t)granules << p->bits) * p->element;
}

enum { PAGE = 4 * sizeof(int32_t) };

static ost_status grow(ost_gl_context *c, ost_gl_pool *p, uint32_t least, ost_error *err)
{
    GLint limit = 0;
    const uint64_t granules = least > 2 * (uint64_t)p->granules ? least : 2 * (uint64_t)p->granules;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    /* Vertex numbers are passed to OpenGL as GLint, so they must not exceed INT32_MAX. */
    if (granules << p->bits > INT32_MAX || (p->format && granules << p->bits > (uint64_t)limit))
        return ost_fail(err, OST_ERR_RANGE, "OpenGL (%s) holds at most %d %s; use --renderer points", c->info.driver,
                        p->format ? (int)limit : INT32_MAX, p->what);
    uint8_t *used = realloc(p->used, granules);
    if (!used)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of %u parts", (unsigned)granules);
    memset(used + p->granules, 0, granules - p->granules);
    p->used = used;
    ost_gl_pool new = *p;
    new.buffer = ost_gl_buffer_make(c, GL_COPY_WRITE_BUFFER, bytes_of(p, (uint32_t)granules), &new.mapped);
    if (p->buffer) {
        glBindBuffer(GL_COPY_READ_BUFFER, p->buffer);
        glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, (GLsizeiptr)bytes_of(p, p->granules));
    }
    new.texture = p->format ? ost_gl_buffer_texture(new.buffer, p->format) : 0;
    new.page_buffer = ost_gl_buffer_make(c, GL_COPY_WRITE_BUFFER, granules * PAGE, &new.page_mapped);
    if (p->page_buffer) {
        glBindBuffer(GL_COPY_READ_BUFFER, p->page_buffer);
        glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, (GLsizeiptr)(p->granules * PAGE));
    }
    new.page_texture = ost_gl_buffer_texture(new.page_buffer, GL_RGBA32I);
    ost_status status = ost_gl_context_check(c, "makes room for voxels", err);
    if (status == OST_OK && c->persistent && (!new.mapped || !new.page_mapped))
        status = ost_fail(err, OST_ERR_MEMORY, "OpenGL (%s) cannot map a buffer of %zu bytes", c->info.driver,
                          bytes_of(p, (uint32_t)granules));
    if (status != OST_OK) {
        free_buffers(&new);
        return status;
    }
    glFinish(); /* the copy must be complete before the buffer is written again */
    free_buffers(p);
    *p = new;
    p->next = p->granules;
    p->granules = (uint32_t)granules;
    return OST_OK;
}

/*
 * Finds the first run of `count` free granules, starting the search at granule `from`. Returns the first granule of
 * this run, or p->granules if there is no such run.
 */
static uint32_t find(const ost_gl_pool *p, uint32_t from, uint32_t count)
{
    uint32_t run = 0;
    for (uint32_t i = from; i < p->granules; i++) {
        run = p->used[i] ? 0 : run + 1;
        if (run == count)
            return i + 1 - count;
    }
    return p->granules;
}

ost_status ost_gl_pool_take(ost_gl_context *context, ost_gl_pool *pool, uint32_t count, uint32_t *first,
                            uint32_t *granules, ost_error *err)
{
    const uint32_t need = (uint32_t)(((uint64_t)count + (1u << pool->bits) - 1) >> pool->bits);
    uint32_t at = find(pool, pool->next, need);
    if (at == pool->granules)
        at = find(pool, 0, need);
    if (at == pool->granules) {
        ost_status status = grow(context, pool, pool->granules + (need > LEAST ? need : LEAST), err);
        if (status != OST_OK)
            return status;
        at = find(pool, pool->next, need);
    }
    memset(pool->used + at, 1, need);
    pool->next = at + need;
    *first = at << pool->bits;
    *granules = need;
    return OST_OK;
}

void ost_gl_pool_give(ost_gl_pool *pool, uint32_t first, uint32_t granules)
{
    memset(pool->used + (first >> pool->bits), 0, granules);
}

static void put(GLuint buffer, void *mapped, size_t at, const void *data, size_t bytes)
{
    if (mapped) {
        memcpy((char *)mapped + at, data, bytes);
        return;
    }
    glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
    glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)at, (GLsizeiptr)bytes, data);
}

void ost_gl_pool_write(const ost_gl_pool *pool, uint32_t first, const void *data, uint32_t count)
{
    put(pool->buffer, pool->mapped, first * pool->element, data, count * pool->element);
}

void ost_gl_pool_place(const ost_gl_pool *pool, uint32_t first, uint32_t granules, const int32_t voxel[3], int32_t more)
{
    const int32_t page[4] = {voxel[0], voxel[1], voxel[2], more};
    for (uint32_t i = 0; i < granules; i++)
        put(pool->page_buffer, pool->page_mapped, ((first >> pool->bits) + i) * (size_t)PAGE, page, sizeof page);
}
