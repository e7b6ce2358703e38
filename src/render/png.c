/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Encodes pictures as PNG with libpng. A file contains only pixels, no time or program name, so equal pictures produce
 * equal files. Only write_file writes to disk, through src/io.
 */
#include <errno.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "render/png.h"

#ifdef HAVE_CONFIG_H
#include "config.h"
#endif

#ifdef HAVE_PNG
#include <png.h>

#include "io/outfile.h"

typedef struct sink {
    uint8_t *bytes;
    size_t size, capacity;
} sink;

static void sink_write(png_structp png, png_bytep data, size_t size)
{
    sink *s = png_get_io_ptr(png);
    if (size > s->capacity - s->size) {
        /* a picture has at most 3 * 2^28 bytes, so this sum does not overflow */
        size_t capacity = 2 * s->capacity + size;
        uint8_t *bytes = realloc(s->bytes, capacity);
        if (!bytes)
            png_error(png, "no memory");
        s->bytes = bytes;
        s->capacity = capacity;
    }
    memcpy(s->bytes + s->size, data, size);
    s->size += size;
}

static void sink_flush(png_structp png)
{
    (void)png;
}

/*
 * On failure, libpng returns to this setjmp by longjmp. Data that are used afterwards are therefore in *s or in the
 * caller's stack frame, not in local variables of this function.
 */
static ost_status encode(png_structp png, png_infop info, const ost_picture *picture, ost_png_effort effort, sink *s,
                         ost_error *err)
{
    if (setjmp(png_jmpbuf(png)))
        return ost_fail(err, OST_ERR_MEMORY, "a picture of %d x %d pixels could not be encoded", picture->width,
                        picture->height);
    png_set_write_fn(png, s, sink_write, sink_flush);
    png_set_IHDR(png, info, (png_uint_32)picture->width, (png_uint_32)picture->height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (effort == OST_PNG_FAST) {
        png_set_compression_level(png, 1);
        png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    }
    png_write_info(png, info);
    for (int y = 0; y < picture->height; y++)
        png_write_row(png, picture->rgb + 3 * (size_t)picture->width * (size_t)y);
    png_write_end(png, NULL);
    return OST_OK;
}

ost_status ost_png_encode(const ost_picture *picture, ost_png_effort effort, uint8_t **bytes, size_t *size,
                          ost_error *err)
{
    *bytes = NULL;
    *size = 0;
    if (!picture->rgb)
        return ost_fail(err, OST_ERR_USAGE, "an empty picture cannot be encoded");
    sink s = {NULL, 0, 0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    ost_status status;
    if (info)
        status = encode(png, info, picture, effort, &s, err);
    else
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for libpng");
    png_destroy_write_struct(&png, &info);
    if (status != OST_OK) {
        free(s.bytes);
        return status;
    }
    *bytes = s.bytes;
    *size = s.size;
    return OST_OK;
}

ost_status ost_picture_encode_png(const ost_picture *picture, uint8_t **bytes, size_t *size, ost_error *err)
{
    return ost_png_encode(picture, OST_PNG_SMALL, bytes, size, err);
}

static ost_status write_file(const char *path, const uint8_t *bytes, size_t size, ost_error *err)
{
    ost_outfile *file = NULL;
    ost_status status = ost_outfile_open(path, &file, err);
    if (status == OST_OK)
        status = ost_outfile_write(file, bytes, size, err);
    if (status == OST_OK)
        return ost_outfile_commit(file, err);
    ost_outfile_discard(file);
    return status;
}

ost_status ost_picture_write_png(const char *path, const ost_picture *picture, ost_error *err)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    ost_status status = ost_picture_encode_png(picture, &bytes, &size, err);
    if (status == OST_OK)
        status = write_file(path, bytes, size, err);
    free(bytes);
    return status;
}

#else

static ost_status without_png(ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without libpng and writes no pictures; Debian: "
                    "install libpng-dev and build again");
}

ost_status ost_png_encode(const ost_picture *picture, ost_png_effort effort, uint8_t **bytes, size_t *size,
                          ost_error *err)
{
    (void)picture;
    (void)effort;
    *bytes = NULL;
    *size = 0;
    return without_png(err);
}

ost_status ost_picture_encode_png(const ost_picture *picture, uint8_t **bytes, size_t *size, ost_error *err)
{
    return ost_png_encode(picture, OST_PNG_SMALL, bytes, size, err);
}

ost_status ost_picture_write_png(const char *path, const ost_picture *picture, ost_error *err)
{
    (void)path;
    (void)picture;
    return without_png(err);
}

#endif
