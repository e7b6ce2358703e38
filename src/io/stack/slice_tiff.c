/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the pages of a TIFF with libtiff.
 *
 * The codecs of libtiff have a long history of defects, so only strips that are uncompressed or use LZW, Deflate or
 * PackBits are accepted. All other pages are refused before a strip is read. libtiff reads through functions in this
 * file, prints nothing, and may allocate at most ALLOC_MAX bytes at once.
 */
#include "config.h"

#include "io/stack/slice.h"

#ifdef HAVE_TIFF

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <tiffio.h>

#include "core/file.h"
#include "core/printable.h"

enum { ALLOC_MAX = 1 << 28, REASON = 200 };

typedef struct tiff_slice {
    ost_slice common; /* must be the first member, because an ost_slice * is cast to this struct */
    TIFF *tiff;
    int fd;
    uint64_t at; /* offset of the next byte that libtiff reads */
    uint32_t index;
    char reason[REASON]; /* first message from libtiff since the last call */
} tiff_slice;

/* ------------------------------------------------------------ libtiff's view */

static tmsize_t read_bytes(thandle_t handle, void *to, tmsize_t size)
{
    tiff_slice *s = handle;
    tmsize_t done = 0;
    while (done < size) {
        const ssize_t n = pread(s->fd, (char *)to + done, (size_t)(size - done), (off_t)(s->at + (uint64_t)done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        done += n;
    }
    s->at += (uint64_t)done;
    return done;
}

static tmsize_t write_bytes(thandle_t handle, void *from, tmsize_t size)
{
    (void)handle, (void)from, (void)size;
    return 0;
}

static toff_t seek(thandle_t handle, toff_t offset, int whence)
{
    tiff_slice *s = handle;
    const uint64_t base = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? s->at : (uint64_t)s->common.bytes;
    s->at = base + offset;
    if (s->at > INT64_MAX) /* pread does not accept an offset beyond INT64_MAX, so nothing is read */
        s->at = INT64_MAX;
    return s->at;
}

static int close_file(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t file_size(thandle_t handle)
{
    return (toff_t)((const tiff_slice *)handle)->common.bytes;
}

static int take_error(TIFF *tiff, void *user, const char *module, const char *format, va_list args)
    OST_PRINTF(4, 0);

/* Stores the first message from libtiff instead of printing it. */
static int take_error(TIFF *tiff, void *user, const char *module, const char *format, va_list args)
{
    tiff_slice *s = user;
    (void)tiff, (void)module;
    if (!s->reason[0]) {
        vsnprintf(s->reason, sizeof s->reason, format, args);
        /* libtiff begins some messages with the name of the file, which the caller prints too. */
        const size_t length = strlen(s->common.path);
        if (strncmp(s->reason, s->common.path, length) == 0 && strncmp(s->reason + length, ": ", 2) == 0)
            memmove(s->reason, s->reason + length + 2, strlen(s->reason + length + 2) + 1);
        ost_make_printable(s->reason);
    }
    return 1;
}

static int ignore_warning(TIFF *tiff, void *user, const char *module, const char *format, va_list args)
{
    (void)tiff, (void)user, (void)module, (void)format, (void)args;
    return 1;
}

/* ----------------------------------------------------------------- one page */

static ost_status refused(const tiff_slice *s, const char *what, unsigned value, const char *expected, ost_error *err)
{
    char name[OST_SLICE_NAME];
    return ost_fail(err, OST_ERR_INPUT, "%s: %s %u; expected %s", ost_slice_name(&s->common, name), what, value,
                    expected);
}

static const char *codec_name(unsigned compression)
{
    switch (compression) {
    case COMPRESSION_NONE: return "raw";
    case COMPRESSION_LZW: return "lzw";
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_DEFLATE: return "deflate";
    case COMPRESSION_PACKBITS: return "packbits";
    default: return NULL;
    }
}

static ost_element element_of(unsigned format, unsigned bits)
{
    static const struct {
        unsigned format, bits;
        ost_element element;
    } elements[] = {
        {SAMPLEFORMAT_UINT, 8, OST_ELEMENT_UINT8},   {SAMPLEFORMAT_UINT, 16, OST_ELEMENT_UINT16},
        {SAMPLEFORMAT_INT, 8, OST_ELEMENT_INT8},     {SAMPLEFORMAT_INT, 16, OST_ELEMENT_INT16},
        {SAMPLEFORMAT_UINT, 32, OST_ELEMENT_UINT32}, {SAMPLEFORMAT_INT, 32, OST_ELEMENT_INT32},
        {SAMPLEFORMAT_IEEEFP, 32, OST_ELEMENT_FLOAT32},
    };
    for (size_t e = 0; e < sizeof elements / sizeof elements[0]; e++)
        if (elements[e].format == format && elements[e].bits == bits)
            return elements[e].element;
    return OST_ELEMENT_NONE;
}

/* Sets the pixel size if the resolution tags state one. */
static void describe_pixel(tiff_slice *s)
{
    static const uint32_t tags[2] = {TIFFTAG_XRESOLUTION, TIFFTAG_YRESOLUTION};
    uint16_t unit = RESUNIT_INCH;
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
    const double mm = unit == RESUNIT_INCH ? 25.4 : unit == RESUNIT_CENTIMETER ? 10 : 0;
    for (int a = 0; a < 2; a++) {
        float resolution = 0;
        if (mm > 0 && TIFFGetField(s->tiff, tags[a], &resolution) && resolution > 1e-6f && resolution < 1e9f)
            s->common.pixel_mm[a] = mm / (double)resolution;
    }
}

/*
 * Refuses ImageJ files that have a TIFF page only for the first slice. The data of the other slices follow those of the
 * first, where only ImageJ finds them.
 */
static ost_status refuse_imagej(const tiff_slice *s, ost_error *err)
{
    char *text = NULL, name[OST_SLICE_NAME];
    if (s->index > 0 || !TIFFGetField(s->tiff, TIFFTAG_IMAGEDESCRIPTION, &text) || !text ||
        strncmp(text, "ImageJ=", 7) != 0)
        return OST_OK;
    const char *images = strstr(text, "\nimages=");
    const long count = images ? strtol(images + 8, NULL, 10) : 1;
    if (count <= 1 || !TIFFLastDirectory(s->tiff))
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "%s: its ImageJ header states %ld slices, but the file has one TIFF page; save "
                    "it with ImageJ as an image sequence or as NRRD", ost_slice_name(&s->common, name), count);
}

static ost_status describe(tiff_slice *s, ost_error *err)
{
    uint16_t samples = 1, bits = 1, format = SAMPLEFORMAT_UINT, photometric = PHOTOMETRIC_MINISBLACK,
             compression = COMPRESSION_NONE, orientation = ORIENTATION_TOPLEFT;
    uint32_t width = 0, height = 0;
    char name[OST_SLICE_NAME];
    ost_slice *c = &s->common;
    TIFFGetField(s->tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(s->tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_ORIENTATION, &orientation);
    TIFFGetFieldDefaulted(s->tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetField(s->tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    if (photometric == PHOTOMETRIC_PALETTE)
        return refused(s, "colours of a palette, photometric interpretation", photometric,
                       "grey values (1); convert the slices to grey", err);
    if (samples != 1)
        return refused(s, "values per pixel:", samples, "1, a density; convert colours to grey", err);
    if (photometric != PHOTOMETRIC_MINISBLACK)
        return refused(s, "photometric interpretation", photometric, "1, in which 0 is black", err);
    if (orientation != ORIENTATION_TOPLEFT)
        return refused(s, "orientation tag", orientation,
                       "1, rows from the top; tiffset -s 274 1 sets it if the rows are in this order", err);
    if (!codec_name(compression))
        return refused(s, "compression", compression, "none, LZW, Deflate or PackBits; tiffcp -c lzw converts it", err);
    if (TIFFIsTiled(s->tiff))
        return ost_fail(err, OST_ERR_INPUT, "%s: its pixels are stored in tiles; tiffcp -s converts it",
                        ost_slice_name(c, name));
    c->element = element_of(format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : format, bits);
    if (c->element == OST_ELEMENT_NONE)
        return refused(s, "bits per value:", bits, "8, 16 or 32, integers or float of 32 bits", err);
    c->width = width > INT32_MAX ? INT32_MAX : (int32_t)width;
    c->height = height > INT32_MAX ? INT32_MAX : (int32_t)height;
    c->packed = compression != COMPRESSION_NONE;
    snprintf(c->encoding, sizeof c->encoding, "%s", codec_name(compression));
    describe_pixel(s);
    ost_status status = ost_slice_check(c, err);
    if (status == OST_OK)
        status = refuse_imagej(s, err);
    if (status == OST_OK && TIFFScanlineSize64(s->tiff) != (uint64_t)c->width * ost_element_bytes(c->element))
        status = ost_fail(err, OST_ERR_INPUT, "%s: rows of %llu bytes; expected %d values of %s",
                          ost_slice_name(c, name), (unsigned long long)TIFFScanlineSize64(s->tiff), (int)c->width,
                          ost_element_name(c->element));
    return status;
}

/* --------------------------------------------------------------- the slice */

static ost_status tiff_row(ost_slice *slice, int32_t y, void *out, ost_error *err)
{
    tiff_slice *s = (tiff_slice *)slice;
    char name[OST_SLICE_NAME];
    s->reason[0] = 0;
    if (TIFFReadScanline(s->tiff, out, (uint32_t)y, 0) == 1)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "%s: cannot read row %d of %d: %s", ost_slice_name(slice, name), (int)y,
                    (int)slice->height, s->reason[0] ? s->reason : "its data are damaged");
}

static ost_status tiff_next(ost_slice *slice, bool *more, ost_error *err)
{
    tiff_slice *s = (tiff_slice *)slice;
    if (TIFFLastDirectory(s->tiff))
        return OST_OK;
    s->reason[0] = 0;
    s->index++;
    slice->page = s->index + 1;
    if (slice->page > OST_DIM_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: more than %d pages", slice->path, OST_DIM_MAX);
    if (!TIFFReadDirectory(s->tiff)) {
        char name[OST_SLICE_NAME];
        return ost_fail(err, OST_ERR_INPUT, "%s: cannot read its tags: %s", ost_slice_name(slice, name),
                        s->reason[0] ? s->reason : "they are damaged");
    }
    *more = true;
    return describe(s, err);
}

static void tiff_close(ost_slice *slice)
{
    tiff_slice *s = (tiff_slice *)slice;
    if (s->tiff)
        TIFFClose(s->tiff);
    if (s->fd >= 0)
        close(s->fd);
}

static ost_status start(tiff_slice *s, ost_error *err)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (!options)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for libtiff", s->common.path);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, ALLOC_MAX);
    TIFFOpenOptionsSetErrorHandlerExtR(options, take_error, s);
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, s);
    /* The mode "m" disables mapping of the file, because a mapped file that shrinks would end the process. */
    s->tiff = TIFFClientOpenExt(s->common.path, "rm", s, read_bytes, write_bytes, seek, close_file, file_size, NULL,
                                NULL, options);
    TIFFOpenOptionsFree(options);
    if (!s->tiff)
        return ost_fail(err, OST_ERR_INPUT, "%s: not a readable TIFF: %s", s->common.path,
                        s->reason[0] ? s->reason : "its header is damaged");
    s->common.page = TIFFLastDirectory(s->tiff) ? 0 : 1;
    return describe(s, err);
}

ost_status ost_slice_open_tiff(const char *path, ost_slice **out, ost_error *err)
{
    ost_file file = {.fd = -1};
    tiff_slice *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s || !(s->common.path = strdup(path))) {
        free(s);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a slice", path);
    }
    s->common.row = tiff_row;
    s->common.next = tiff_next;
    s->common.close = tiff_close;
    ost_status status = ost_file_open(path, &file, err);
    s->fd = file.fd;
    s->common.bytes = file.size;
    if (status == OST_OK)
        status = start(s, err);
    if (status == OST_OK)
        *out = &s->common;
    else
        ost_slice_close(&s->common);
    return status;
}

#else

ost_status ost_slice_open_tiff(const char *path, ost_slice **out, ost_error *err)
{
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: cannot read TIFF: osteon was built without libtiff; install libtiff (Debian: libtiff-dev) and "
                    "build again", path);
}

#endif
