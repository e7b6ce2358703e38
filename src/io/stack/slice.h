/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a picture file of a stack row by row. The file contains one grey picture (PNG, TIFF) or several pages (TIFF).
 *
 *   open: first page --next--> second page ...
 *          row 0, row 1, ... in this order
 *
 * A file may be malicious. Only grey pictures with one value per pixel are accepted, and their form is checked before
 * any row is read. The width and the height of a picture are at most OST_DIM_MAX. libtiff may allocate at most 256 MiB
 * at once, which also limits the size of a strip. A PNG chunk that contains no pixels may have at most 1 MiB. Before
 * the grid is allocated, the reader checks that the unpacked size is at most OST_SLICE_UNPACK_MAX times the file size.
 */
#ifndef OST_IO_STACK_SLICE_H
#define OST_IO_STACK_SLICE_H

#include <osteon/grid.h>

#include "io/volume/element.h"

/*
 * Maximum ratio of unpacked bytes to bytes of the file. Deflate reaches 1032, LZW with 12-bit codes reaches 1365, and
 * PackBits reaches 64.
 */
enum { OST_SLICE_UNPACK_MAX = 1400 };

typedef enum ost_slice_kind { OST_SLICE_NONE, OST_SLICE_TIFF, OST_SLICE_PNG } ost_slice_kind;

typedef struct ost_slice ost_slice;
struct ost_slice {
    /* Reads row y, which has `width` elements. Each row must be read once, in order. Reading the last row also checks
     * the end of the data. */
    ost_status (*row)(ost_slice *slice, int32_t y, void *out, ost_error *err);
    /* Moves to the next page and describes the page. Sets *more to false if there is no next page. */
    ost_status (*next)(ost_slice *slice, bool *more, ost_error *err);
    void (*close)(ost_slice *slice);
    char *path;       /* owned */
    int64_t bytes;    /* file size in bytes */
    uint32_t page;    /* number of the page, counted from 1; 0 if the file has only one page */
    int32_t width, height;
    ost_element element;
    bool swap;        /* true if rows are big-endian */
    bool packed;      /* true if rows are compressed */
    char encoding[16];
    double pixel_mm[2]; /* width and height of a pixel in mm, as stated by the file; 0 if the file states no size */
};

/* Returns the format that the first bytes of a file indicate. */
ost_slice_kind ost_slice_sniff(const unsigned char *head, size_t size);
/* Returns the format that the first bytes of the file at `path` indicate (slice_open.c). Errors name the file. */
ost_status ost_slice_sniff_file(const char *path, ost_slice_kind *kind, ost_error *err);

/*
 * Opens a file and describes its first page (slice_open.c). The first bytes of the file determine its format. Errors
 * name the file.
 */
ost_status ost_slice_open(const char *path, ost_slice **out, ost_error *err);
ost_status ost_slice_row(ost_slice *slice, int32_t y, void *out, ost_error *err);
ost_status ost_slice_next(ost_slice *slice, bool *more, ost_error *err);
void ost_slice_close(ost_slice *slice); /* NULL is allowed */

/* Writes the slice's name, "FILE" or "FILE: page N", to `text` for messages. Returns `text`. */
enum { OST_SLICE_NAME = 4200 };
const char *ost_slice_name(const ost_slice *slice, char text[OST_SLICE_NAME]);

/* Checks the size and the element type of a slice. Called by the reader of a format, after all fields are set. */
ost_status ost_slice_check(const ost_slice *slice, ost_error *err);

/* Each function opens a file of one format and describes its first page. */
ost_status ost_slice_open_tiff(const char *path, ost_slice **out, ost_error *err);
ost_status ost_slice_open_png(const char *path, ost_slice **out, ost_error *err);

#endif
