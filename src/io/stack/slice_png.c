/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a grey PNG with libpng, row by row. libpng reports a failure by longjmp. Each function that calls libpng
 * therefore calls setjmp first, and keeps all data that are used after the longjmp in the object.
 */
#include "config.h"

#include "io/stack/slice.h"

#ifdef HAVE_PNG

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <png.h>

#include "core/file.h"
#include "core/printable.h"

enum { CHUNK_MAX = 1 << 20, CHUNKS_MAX = 64, REASON = 200 };

typedef struct png_slice {
    ost_slice common; /* must be the first member, because an ost_slice * is cast to this struct */
    png_structp png;
    png_infop info;
    FILE *file;
    char reason[REASON]; /* message of libpng */
} png_slice;

static void take_error(png_structp png, png_const_charp message)
{
    png_slice *s = png_get_error_ptr(png);
    snprintf(s->reason, sizeof s->reason, "%s", message);
    ost_make_printable(s->reason);
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message)
{
    (void)png, (void)message;
}

static ost_status refused(const png_slice *s, const char *what, int value, const char *expected, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %s %d; expected %s", s->common.path, what, value, expected);
}

static ost_status read_info(png_slice *s, ost_error *err)
{
    if (setjmp(png_jmpbuf(s->png)))
        return ost_fail(err, OST_ERR_INPUT, "%s: not a readable PNG: %s", s->common.path, s->reason);
    png_set_user_limits(s->png, OST_DIM_MAX, OST_DIM_MAX);
    png_set_chunk_malloc_max(s->png, CHUNK_MAX);
    png_set_chunk_cache_max(s->png, CHUNKS_MAX);
    png_init_io(s->png, s->file);
    png_read_info(s->png, s->info);
    return OST_OK;
}

static ost_status describe(png_slice *s, ost_error *err)
{
    ost_slice *c = &s->common;
    const int colour = png_get_color_type(s->png, s->info), bits = png_get_bit_depth(s->png, s->info);
    if (colour == PNG_COLOR_TYPE_PALETTE)
        return refused(s, "colours of a palette, colour type", colour, "grey values (0); convert the slices to grey",
                       err);
    if (colour != PNG_COLOR_TYPE_GRAY)
        return refused(s, "colour type", colour, "grey values without alpha (0); convert the slices to grey", err);
    if (bits != 8 && bits != 16)
        return refused(s, "bits per value:", bits, "8 or 16", err);
    if (png_get_interlace_type(s->png, s->info) != PNG_INTERLACE_NONE)
        return ost_fail(err, OST_ERR_INPUT, "%s: is interlaced; save it again without interlacing", c->path);
    c->element = bits == 8 ? OST_ELEMENT_UINT8 : OST_ELEMENT_UINT16;
    c->swap = true; /* samples in a PNG file are big-endian */
    c->packed = true;
    snprintf(c->encoding, sizeof c->encoding, "deflate");
    c->width = (int32_t)png_get_image_width(s->png, s->info);
    c->height = (int32_t)png_get_image_height(s->png, s->info);
    const png_uint_32 per_metre[2] = {png_get_x_pixels_per_meter(s->png, s->info),
                                      png_get_y_pixels_per_meter(s->png, s->info)};
    for (int a = 0; a < 2; a++)
        c->pixel_mm[a] = per_metre[a] ? 1000.0 / per_metre[a] : 0;
    return ost_slice_check(c, err);
}

static ost_status png_row(ost_slice *slice, int32_t y, void *out, ost_error *err)
{
    png_slice *s = (png_slice *)slice;
    if (setjmp(png_jmpbuf(s->png)))
        return ost_fail(err, OST_ERR_INPUT, "%s: cannot read row %d of %d: %s", slice->path, (int)y,
                        (int)slice->height, s->reason);
    png_read_row(s->png, out, NULL);
    if (y + 1 == slice->height)
        png_read_end(s->png, NULL);
    return OST_OK;
}

static void png_close(ost_slice *slice)
{
    png_slice *s = (png_slice *)slice;
    png_destroy_read_struct(&s->png, &s->info, NULL);
    if (s->file)
        fclose(s->file);
}

static ost_status start(png_slice *s, ost_error *err)
{
    struct stat info;
    ost_status status = ost_file_stream(s->common.path, &s->file, NULL, err);
    if (status != OST_OK)
        return status;
    s->common.bytes = fstat(fileno(s->file), &info) == 0 ? info.st_size : 0;
    s->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, s, take_error, ignore_warning);
    s->info = s->png ? png_create_info_struct(s->png) : NULL;
    if (!s->info)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for libpng", s->common.path);
    status = read_info(s, err);
    return status == OST_OK ? describe(s, err) : status;
}

ost_status ost_slice_open_png(const char *path, ost_slice **out, ost_error *err)
{
    png_slice *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s || !(s->common.path = strdup(path))) {
        free(s);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a slice", path);
    }
    s->common.row = png_row;
    s->common.close = png_close;
    const ost_status status = start(s, err);
    if (status == OST_OK)
        *out = &s->common;
    else
        ost_slice_close(&s->common);
    return status;
}

#else

ost_status ost_slice_open_png(const char *path, ost_slice **out, ost_error *err)
{
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: cannot read PNG: osteon was built without libpng; install libpng (Debian: libpng-dev) and "
                    "build again", path);
}

#endif
