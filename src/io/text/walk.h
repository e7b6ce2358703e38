/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pieces of a scan, line by line (raster.h).
 *
 *   file  |--- head ---|---- piece ----|---- piece ----|-- ...
 *                           ^ first line that begins in it: parsed, so its
 *                             place is known; from there on places follow
 *
 * A line that is not matched is parsed as any text's, and what it says must be
 * what its place asks for; then it gives the pattern for those after it.
 *
 *   "-57.340000 12.220000 3.000000 1043\n"
 *    |--piece-||--piece-||-piece-||          a position and what is in front of it
 *
 * When a row ends, the next one's pattern is this one's with the piece that
 * the middle axis had in that row of the first slice.  Each piece but the first
 * begins with what separates it, so pieces put together are read as they
 * were read apart, and a line of those bytes needs no parsing either.
 */
#ifndef OST_IO_TEXT_WALK_H
#define OST_IO_TEXT_WALK_H

#include "io/text/match.h"
#include "io/text/raster.h"

/* What all walkers go by; ranks as in ost_text_raster. */
typedef struct ost_text_plan {
    const char *path;
    int fd;
    int64_t begin, end;  /* bytes of the file: from the first sample's line on */
    ost_text_raster *raster;
    ost_text_column *columns; /* owned; raster->count[0] */
    uint8_t *lengths;         /* owned; of their texts; 0 in one whose text is too long */
    ost_text_column *middles; /* owned; pieces of the middle axis, raster->count[1] */
    uint8_t *middle_lengths;  /* owned; 0 of one that is too long */
    uint32_t shortest;        /* the least of the columns' lengths */
    bool fast;                /* every column has a text */
    bool carriage;
    ost_pm last_slow;
    ost_text_match *match;
} ost_text_plan;

typedef struct ost_text_walker {
    const ost_text_plan *plan;
    bool learning;       /* the middle axis is what is found; voxels is one row */
    bool done;           /* learning: the first slice has ended, */
    ost_pm second_slow;  /* and this is the second one's coordinate */
    bool placed;         /* a line has been met */
    bool known;          /* pattern holds in this row */
    int32_t at[3];       /* the next line's place, by rank; at[0] == count: the row has ended */
    ost_pm middle, slow; /* of this row */
    int64_t first, next; /* lines walked are the voxels [first, next) */
    int32_t first_slow_index;
    ost_pm first_slow;   /* of the first line */
    uint32_t units[3];   /* by axis, as in ost_text_axis */
    ost_text_pattern pattern;
    ost_text_around piece[3]; /* by axis, of the row that pattern holds in; that of the fastest axis is not kept */
    ost_text_around gap;      /* between the last position and the density */
    ost_text_parser parser;
    char *buffer;        /* owned */
    int16_t *row;        /* owned; learning only */
} ost_text_walker;

/* False when there is no memory; close is safe then. */
bool ost_text_walker_open(ost_text_walker *walker, const ost_text_plan *plan, bool learning);
void ost_text_walker_close(ost_text_walker *walker);

/*
 * Walks the lines that begin in bytes [begin, end) of the file.  inside: begin
 * is anywhere, not at a line's begin.  False when some line is not what its
 * place asks for.
 */
bool ost_text_walk(ost_text_walker *walker, int64_t begin, int64_t end, bool inside);

/* The line [p, end) without its newline as a row; false when it is none, or one that was rounded. */
bool ost_text_walk_parse(ost_text_parser *parser, const char *p, const char *newline, ost_text_row *row);

/* The ends of the three positions and the begin of the density in a line that is a row. */
typedef struct ost_text_marks {
    const char *end[3];
    const char *density;
} ost_text_marks;
ost_text_marks ost_text_mark(const char *p, const char *newline);

/* False, and a length of 0, when the text is too long. */
bool ost_text_column_set(ost_text_column *column, uint8_t *length, const char *p, const char *end);

#endif
