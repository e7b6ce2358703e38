/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The location of a NRRD's data: after the header, or in files that the header names.
 *
 *   data file: name                         one file
 *   data file: name.%03d MIN MAX STEP [D]   numbered files
 *   data file: LIST [D]                     followed by one name per line
 *
 * D is the number of axes that each file contains completely (default 2, slices; 3
 * divides the last axis into slabs); the files follow each other without gaps, and
 * their number must match the sizes.  A file begins with `line skip` lines, then
 * `byte skip` bytes (counted after unpacking, if it is packed), then the data.
 *
 * A header may be malicious, so a data file must be in the header's folder or below
 * it. Absolute names and any ".." are refused.
 */
#ifndef OST_IO_NRRD_PARTS_H
#define OST_IO_NRRD_PARTS_H

#include "io/nrrd/header.h"
#include "io/volume/parts.h"

enum { OST_NRRD_PARTS_MAX = 1 << 16, OST_NRRD_NAME_MAX = 4096 };

typedef struct ost_nrrd_parts {
    const char *path; /* path of the header */
    const ost_nrrd_text *text;
    const ost_nrrd_header *header;
    uint64_t attached_at; /* offset in the header's file at which its own data start */
    bool attached;
    uint64_t part_bytes;
    /* for a numbered list */
    const char *pattern; /* has pattern_length bytes */
    size_t pattern_length;
    int64_t first, step;
    uint64_t count;
    /* for LIST: the next name, so that all names are found in one pass */
    const char *list_at;
    uint64_t list_index;
} ost_nrrd_parts;

/*
 * Sets parts->open and the other fields of *parts; own must outlive it. header_end is the offset of the first byte
 * after the header.
 */
ost_status ost_nrrd_parts_init(ost_nrrd_parts *own, ost_parts *parts, const char *path, const ost_nrrd_text *text,
                               const ost_nrrd_header *header, uint64_t header_end, ost_error *err);

#endif
