/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a NRRD header's data are: behind it, or in files that it names.
 *
 *   data file: name                         one file
 *   data file: name.%03d MIN MAX STEP [D]   numbered files
 *   data file: LIST [D]                     then one name a line
 *
 * D is how many axes a file holds whole (2, slices, when not given; 3 cuts the
 * last axis into slabs); the files follow each other without gap, and their
 * number must fit the sizes.  Within a file come `line skip` lines, then
 * (unpacked, where packed) `byte skip` bytes, then data.
 *
 * A header is hostile input: a data file must lie in the header's folder or
 * below it.  Absolute names and any ".." are refused.
 */
#ifndef OST_IO_NRRD_PARTS_H
#define OST_IO_NRRD_PARTS_H

#include "io/nrrd/header.h"
#include "io/volume/parts.h"

enum { OST_NRRD_PARTS_MAX = 1 << 16, OST_NRRD_NAME_MAX = 4096 };

typedef struct ost_nrrd_parts {
    const char *path; /* of the header */
    const ost_nrrd_text *text;
    const ost_nrrd_header *header;
    uint64_t attached_at; /* byte of the header's file where its own data start */
    bool attached;
    uint64_t part_bytes;
    /* of a numbered list */
    const char *pattern; /* ends in pattern_length */
    size_t pattern_length;
    int64_t first, step;
    uint64_t count;
    /* of LIST: the name that comes next, so that names are found in one pass */
    const char *list_at;
    uint64_t list_index;
} ost_nrrd_parts;

/* header_end is the first byte after the header. parts->open and the rest of *parts are set; own must outlive it. */
ost_status ost_nrrd_parts_init(ost_nrrd_parts *own, ost_parts *parts, const char *path, const ost_nrrd_text *text,
                               const ost_nrrd_header *header, uint64_t header_end, ost_error *err);

#endif
