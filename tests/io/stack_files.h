/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Builds TIFF 6.0 files with one strip per page, and PNG files with one IDAT chunk. The files are built byte by
 * byte according to the format specifications, without libtiff or libpng.
 */
#ifndef OST_TESTS_STACK_FILES_H
#define OST_TESTS_STACK_FILES_H

#include "volume_files.h"

/* The tags of a TIFF page. The tag of a field that is 0 is omitted, except that `photometric` is always stored. */
typedef struct tiff_page {
    uint32_t width, height;
    unsigned bits, format, compression, photometric, samples, orientation, tile;
    unsigned resolution;     /* in pixels per centimetre; if 0, the page has no resolution tags */
    const char *description;
    const void *data;        /* the bytes of the strip in the file's byte order */
    size_t size;
    uint32_t strip_bytes;    /* value of the tag StripByteCounts; 0 means `size` */
} tiff_page;

/* Returns a page of one byte per pixel without compression. */
static inline tiff_page tiff_plain(uint32_t width, uint32_t height, unsigned bits, const void *data, size_t size)
{
    return (tiff_page){.width = width, .height = height, .bits = bits, .compression = 1, .photometric = 1,
                       .samples = 1, .data = data, .size = size};
}

/*
 * Appends an entry of type ASCII (2), SHORT (3), LONG (4) or RATIONAL (5). A single SHORT is stored in the first
 * half of the entry's value field.
 */
static inline void put_entry(bytes *b, bool big, unsigned tag, unsigned type, uint32_t count, uint32_t value)
{
    put_bits(b, tag, 2, big);
    put_bits(b, type, 2, big);
    put_bits(b, count, 4, big);
    if (type == 3 && count == 1) {
        put_bits(b, value, 2, big);
        put_bits(b, 0, 2, big);
    } else {
        put_bits(b, value, 4, big);
    }
}

/*
 * Appends a TIFF file with these pages. The layout of each page is: strip, resolution, description,
 * directory. Therefore every offset except the offset of the next directory can be written immediately.
 */
static inline void put_tiff(bytes *b, bool big, const tiff_page *pages, size_t count)
{
    put_text(b, big ? "MM" : "II");
    put_bits(b, 42, 2, big);
    size_t link = b->size; /* position of the offset of the next directory */
    put_bits(b, 0, 4, big);
    for (size_t p = 0; p < count; p++) {
        const tiff_page *t = &pages[p];
        const size_t strip = b->size;
        put_bytes(b, t->data, t->size);
        const size_t rational = b->size;
        put_bits(b, t->resolution, 4, big);
        put_bits(b, 1, 4, big);
        const size_t text = b->size, text_size = t->description ? strlen(t->description) + 1 : 0;
        put_bytes(b, t->description ? t->description : "", text_size);
        const bool palette = t->photometric == 3;
        if (b->size & 1)
            put_bits(b, 0, 1, big);
        const size_t colours = b->size;
        for (int c = 0; palette && c < 3 << t->bits; c++)
            put_bits(b, (uint64_t)c, 2, big);
        bytes offset = {0};
        put_bits(&offset, b->size, 4, big);
        memcpy(b->data + link, offset.data, 4);

        const struct {
            unsigned tag, type;
            uint32_t value;
            bool present;
            uint32_t count; /* number of values; 0 means one value */
        } entries[] = {
            {256, 4, t->width, t->width, 0},
            {257, 4, t->height, t->height, 0},
            {258, 3, t->bits, t->bits, 0},
            {259, 3, t->compression, t->compression, 0},
            {262, 3, t->photometric, true, 0},
            {270, 2, (uint32_t)text, t->description, (uint32_t)text_size},
            {273, 4, (uint32_t)strip, !t->tile, 0},
            {274, 3, t->orientation, t->orientation, 0},
            {277, 3, t->samples, t->samples, 0},
            {278, 4, t->height, !t->tile, 0},
            {279, 4, t->strip_bytes ? t->strip_bytes : (uint32_t)t->size, !t->tile, 0},
            {282, 5, (uint32_t)rational, t->resolution, 0},
            {283, 5, (uint32_t)rational, t->resolution, 0},
            {296, 3, 3, t->resolution, 0},
            {320, 3, (uint32_t)colours, palette, palette ? 3u << t->bits : 0},
            {322, 4, t->tile, t->tile, 0},
            {323, 4, t->tile, t->tile, 0},
            {324, 4, (uint32_t)strip, t->tile, 0},
            {325, 4, (uint32_t)t->size, t->tile, 0},
            {339, 3, t->format, t->format, 0},
        };
        unsigned present = 0;
        for (size_t e = 0; e < sizeof entries / sizeof entries[0]; e++)
            present += entries[e].present;
        put_bits(b, present, 2, big);
        for (size_t e = 0; e < sizeof entries / sizeof entries[0]; e++)
            if (entries[e].present)
                put_entry(b, big, entries[e].tag, entries[e].type, entries[e].count ? entries[e].count : 1,
                          entries[e].value);
        link = b->size;
        put_bits(b, 0, 4, big);
    }
}

static inline void write_tiff(const char *name, bool big, const tiff_page *pages, size_t count)
{
    static bytes file;
    file.size = 0;
    put_tiff(&file, big, pages, count);
    write_file(name, file.data, file.size);
}

static inline void put_chunk(bytes *b, const char *type, const void *data, size_t size)
{
    const size_t start = b->size + 4;
    put_bits(b, size, 4, true);
    put_text(b, type);
    put_bytes(b, data, size);
    put_bits(b, crc32(0, b->data + start, (uInt)(size + 4)), 4, true);
}

/* Appends a PNG file. `rows` contains the pixels in the byte order of PNG, with row_bytes bytes per row. All rows
   have filter 0. */
static inline void put_png(bytes *b, uint32_t width, uint32_t height, unsigned bits, unsigned colour,
                           unsigned interlace, const unsigned char *rows, size_t row_bytes, size_t row_count)
{
    static bytes head, raw, packed;
    head.size = raw.size = packed.size = 0;
    put_bytes(b, "\x89PNG\r\n\x1a\n", 8);
    put_bits(&head, width, 4, true);
    put_bits(&head, height, 4, true);
    put_bits(&head, bits, 1, true);
    put_bits(&head, colour, 1, true);
    put_bits(&head, 0, 2, true); /* compression method and filter method, one byte each */
    put_bits(&head, interlace, 1, true);
    put_chunk(b, "IHDR", head.data, head.size);
    if (colour == 3)
        put_chunk(b, "PLTE", "\0\0\0\1\1\1", 6);
    for (size_t r = 0; r < row_count; r++) {
        put_bits(&raw, 0, 1, true);
        put_bytes(&raw, rows + r * row_bytes, row_bytes);
    }
    put_deflated(&packed, raw.data, raw.size, 15);
    put_chunk(b, "IDAT", packed.data, packed.size);
    put_chunk(b, "IEND", "", 0);
}

#endif
