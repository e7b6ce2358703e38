/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture file of a stack: one grey picture (PNG, TIFF) or several pages (TIFF), read row by row.
 *
 *   open: first page --next--> second page ...
 *          row 0, row 1, ... in this order
 *
 * A file is hostile. Only grey pictures with one value per pixel are read; their form is checked before
 * a row is. Sizes are limited to OST_DIM_MAX, one allocation of libtiff to 256 MiB (the greatest strip),
 * one chunk of a PNG other than pixels to 1 MiB. A file may unpack to at most
 * OST_SLICE_UNPACK_MAX times its size, which is checked before the grid is allocated.
 */
#ifndef OST_IO_STACK_SLICE_H
#define OST_IO_STACK_SLICE_H

#include <osteon/grid.h>

#include "io/volume/element.h"

/*
 * The greatest number of unpacked bytes per byte of a file: deflate reaches 1032, LZW with codes of 12
 * bits 1365, PackBits 64.
 */
enum { OST_SLICE_UNPACK_MAX = 1400 };

typedef enum ost_slice_kind { OST_SLICE_NONE, OST_SLICE_TIFF, OST_SLICE_PNG } ost_slice_kind;

typedef struct ost_slice ost_slice;
struct ost_slice {
    /* Reads row y as width elements. Rows are read in order, each once. The last row also ends the data. */
    ost_status (*row)(ost_slice *slice, int32_t y, void *out, ost_error *err);
    /* Moves to the next page and describes it, or sets *more to false. */
    ost_status (*next)(ost_slice *slice, bool *more, ost_error *err);
    void (*close)(ost_slice *slice);
    char *path;       /* owned */
    int64_t bytes;    /* size of the file */
    uint32_t page;    /* number of the page, from 1; 0 if the file has only one */
    int32_t width, height;
    ost_element element;
    bool swap;        /* rows are big-endian */
    bool packed;      /* rows are compressed */
    char encoding[16];
    double pixel_mm[2]; /* width and height of a pixel that the file states; 0 if it states none */
};

/* Returns the format that the first bytes of a file identify. */
ost_slice_kind ost_slice_sniff(const unsigned char *head, size_t size);

/* Opens a file by its content and describes its first page (slice_open.c). Errors name the file. */
ost_status ost_slice_open(const char *path, ost_slice **out, ost_error *err);
ost_status ost_slice_row(ost_slice *slice, int32_t y, void *out, ost_error *err);
ost_status ost_slice_next(ost_slice *slice, bool *more, ost_error *err);
void ost_slice_close(ost_slice *slice); /* NULL is allowed */

/* Writes "FILE" or "FILE: page N", for messages, and returns text. */
enum { OST_SLICE_NAME = 4200 };
const char *ost_slice_name(const ost_slice *slice, char text[OST_SLICE_NAME]);

/* Called by the code of a format after it has set the fields: checks size and element, in this order. */
ost_status ost_slice_check(const ost_slice *slice, ost_error *err);

/* The two formats. Each sets *out to an open file whose first page is described. */
ost_status ost_slice_open_tiff(const char *path, ost_slice **out, ost_error *err);
ost_status ost_slice_open_png(const char *path, ost_slice **out, ost_error *err);

#endif
