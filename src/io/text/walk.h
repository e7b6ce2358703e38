/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Walks pieces of a scan, line by line (raster.h).
 *
 *   file  |--- head ---|---- piece ----|---- piece ----|-- ...
 *                           ^ first line that begins in it: parsed to find its
 *                             voxel; the voxels of the lines after it follow
 *
 * A line that is not matched is parsed like any text, and its position must be the
 * one that is expected there. It then provides the pattern for the lines after it.
 *
 *   "-57.340000 12.220000 3.000000 1043\n"
 *    |--text--||--text--||--text-|           a position with the characters in front of it
 *
 * When a row ends, the pattern of the next row is derived from the current one: the text
 * of the middle axis is replaced by its text in the same row of the first slice. Every
 * text except the first begins with its separator, so the concatenated texts are parsed as
 * the separate texts were. Therefore, a line that consists of these bytes is not parsed
 * either.
 */
#ifndef OST_IO_TEXT_WALK_H
#define OST_IO_TEXT_WALK_H

#include "io/text/match.h"
#include "io/text/raster.h"

/* The data that all walkers share. Ranks are those of ost_text_raster. */
typedef struct ost_text_plan {
    const char *path;
    int fd;
    int64_t begin, end;  /* range of bytes in the file: from the first sample's line on */
    ost_text_raster *raster;
    ost_text_column *columns; /* owned; raster->count[0] */
    uint8_t *lengths;         /* owned; length of each column's text; 0 if the text is too long */
    ost_text_column *middles; /* owned; texts of the middle axis, raster->count[1] of them */
    uint8_t *middle_lengths;  /* owned; length of each text in middles; 0 if the text is too long */
    uint32_t shortest;        /* the least length of a column */
    bool fast;                /* every column's text fits into its array */
    bool carriage;
    ost_pm last_slow;
    ost_text_match *match;
} ost_text_plan;

typedef struct ost_text_walker {
    const ost_text_plan *plan;
    bool learning;       /* the walk finds the coordinates of the middle axis, and stores voxels in `row` */
    bool done;           /* the first slice has ended; used only if learning is true */
    ost_pm second_slow;  /* coordinate of the second slice; valid if done is true */
    bool placed;         /* a line has been read, so `at` is valid */
    bool known;          /* pattern is valid in this row */
    int32_t at[3];       /* position of the next line, by rank; the row has ended if at[0] == count */
    ost_pm middle, slow; /* coordinates of this row */
    int64_t first, next; /* the lines walked are the voxels [first, next) */
    int32_t first_slow_index;
    ost_pm first_slow;   /* coordinate of the first line */
    uint32_t units[3];   /* decimal units that occur on each axis, as in ost_text_axis */
    ost_text_pattern pattern;
    ost_text_around piece[3]; /* text of each axis except the fastest, in the row of the pattern */
    ost_text_around gap;      /* the characters between the last position and the density */
    ost_text_parser parser;
    char *buffer;        /* owned */
    int16_t *row;        /* owned; only if learning */
} ost_text_walker;

/* Opens a walker. Returns false if there is no memory. The walker can be closed in this case too. */
bool ost_text_walker_open(ost_text_walker *walker, const ost_text_plan *plan, bool learning);
void ost_text_walker_close(ost_text_walker *walker);

/*
 * Walks the lines that begin in bytes [begin, end) of the file.  inside is true if
 * begin may be within a line. Returns false if some line is not the expected one.
 */
bool ost_text_walk(ost_text_walker *walker, int64_t begin, int64_t end, bool inside);

/* Parses the line [p, newline) as a row. Returns false if it is not a row, or if a position was rounded. */
bool ost_text_walk_parse(ost_text_parser *parser, const char *p, const char *newline, ost_text_row *row);

/* The ends of the three positions and the beginning of the density in a line that is a row. */
typedef struct ost_text_marks {
    const char *end[3];
    const char *density;
} ost_text_marks;
ost_text_marks ost_text_mark(const char *p, const char *newline);

/* Stores the text [p, end) of a column. Returns false and sets the length to 0 if it is too long. */
bool ost_text_column_set(ost_text_column *column, uint8_t *length, const char *p, const char *end);

#endif
