/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Processes pieces of a raster scan (raster.h) line by line. The processing of a piece is called a walk.
 *
 *   file  |--- head ---|---- piece ----|---- piece ----|-- ...
 *                           ^ first line that begins in the piece: parsed to find its
 *                             voxel; the voxels of the lines after it follow
 *
 * A line that does not match the pattern is parsed. If its position is the expected one, its text becomes the pattern
 * for the following lines; otherwise, the file is not a raster scan.
 *
 *   "-57.340000 12.220000 3.000000 1043\n"
 *    |--text--||--text--||--text-|           a position with the characters in front of it
 *
 * When a row ends, the pattern of the next row is derived from the current one: the text of the middle axis is replaced
 * by the text that this axis has in the same row of the first slice. A line that matches the derived pattern need not
 * be parsed: every text except the first begins with its separator, so joined texts represent the same numbers.
 */
#ifndef OST_IO_TEXT_WALK_H
#define OST_IO_TEXT_WALK_H

#include "io/text/match.h"
#include "io/text/raster.h"

/* The data that all walkers share. Arrays with one element per axis are indexed by rank, as in ost_text_raster. */
typedef struct ost_text_plan {
    const char *path;
    int fd;
    int64_t begin, end;  /* range of bytes in the file, from the line of the first sample to the end */
    ost_text_raster *raster;
    ost_text_column *columns; /* owned; strings of the columns; raster->count[0] elements */
    uint8_t *lengths;         /* owned; length of each string in `columns`; 0 if the string is too long */
    ost_text_column *middles; /* owned; strings of the middle axis; raster->count[1] elements */
    uint8_t *middle_lengths;  /* owned; length of each string in `middles`; 0 if the string is too long */
    uint32_t shortest;        /* minimum length of a column's string */
    bool fast;                /* true if no string in `columns` is too long */
    bool carriage;
    ost_pm last_slow;
    ost_text_match *match;
} ost_text_plan;

typedef struct ost_text_walker {
    const ost_text_plan *plan;
    /* true in the walk over the first slice, which finds the coordinates of the middle axis and fills `row` */
    bool learning;
    bool done;           /* true once the first slice has ended; used only if `learning` is true */
    ost_pm second_slow;  /* coordinate of the second slice; valid only if `done` is true */
    bool placed;         /* true if a line has been read, so that `at` is valid */
    bool known;          /* true if the pattern applies to the current row */
    /* index of the next line's coordinate on each axis, by rank; at[0] == count[0] at the end of a row */
    int32_t at[3];
    ost_pm middle, slow; /* coordinates of the current row on the middle and the slow axis */
    int64_t first, next; /* range of the voxels whose lines have been processed */
    int32_t first_slow_index;
    ost_pm first_slow;   /* slow coordinate of the first processed line; its index is first_slow_index */
    uint32_t units[3];   /* decimal units that occur on each axis, as in ost_text_axis */
    ost_text_pattern pattern;
    ost_text_around piece[3]; /* text of each axis except the fastest, in the row of the pattern */
    ost_text_around gap;      /* characters between the last coordinate and the density */
    ost_text_parser parser;
    char *buffer;        /* owned */
    int16_t *row;        /* owned; densities of the current row; allocated only if `learning` is true */
} ost_text_walker;

/* Opens a walker. Returns false if memory is exhausted; the walker can then still be closed. */
bool ost_text_walker_open(ost_text_walker *walker, const ost_text_plan *plan, bool learning);
void ost_text_walker_close(ost_text_walker *walker);

/*
 * Processes the lines that begin in the bytes [begin, end) of the file. `inside` is true if `begin` may lie within a
 * line. Returns false if a line deviates from a raster scan.
 */
bool ost_text_walk(ost_text_walker *walker, int64_t begin, int64_t end, bool inside);

/* Parses the line [p, newline) as a row. Returns false if the line is not a row, or if a position was rounded. */
bool ost_text_walk_parse(ost_text_parser *parser, const char *p, const char *newline, ost_text_row *row);

/* Positions in a line that is a row: the ends of the three coordinates, and the beginning of the density. */
typedef struct ost_text_marks {
    const char *end[3];
    const char *density;
} ost_text_marks;
ost_text_marks ost_text_mark(const char *p, const char *newline);

/* Stores the text [p, end) of a column. If the text is too long, returns false and sets the length to 0. */
bool ost_text_column_set(ost_text_column *column, uint8_t *length, const char *p, const char *end);

#endif
