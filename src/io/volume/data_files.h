/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the data that belong to a NRRD or MetaImage header. The data follow the header or are in files that the header
 * names.
 *
 *   name                         one file
 *   name.%03d MIN MAX STEP [D]   numbered files
 *   LIST [D]                     followed by one name per line
 *
 * D is the number of axes that each file contains completely. The default, 2, means one slice per file; 3 means that
 * the last axis is divided into slabs. The files follow each other without gaps, and their number must match the sizes.
 * A file begins with line_skip lines, then byte_skip bytes (counted after decompression, if it is compressed), then the
 * data.
 *
 * A header may be malicious, so a data file must be in the header's folder or below it. Absolute names and any ".." are
 * refused.
 */
#ifndef OST_IO_VOLUME_DATA_FILES_H
#define OST_IO_VOLUME_DATA_FILES_H

#include "io/volume/parts.h"

enum { OST_DATA_FILES_MAX = 1 << 16, OST_DATA_NAME_MAX = 4096 };

typedef enum ost_data_form { OST_DATA_RAW, OST_DATA_GZIP, OST_DATA_ZLIB, OST_DATA_TEXT } ost_data_form;

/* The file names as the header states them. The strings belong to the text of the header. */
typedef struct ost_data_names {
    const char *value; /* value of the field that names the files; NULL if the data follow the header */
    long line;         /* number of the line that contains the field, for messages */
    const char *list;  /* file names after LIST, each terminated by NUL; NULL if the value is not LIST */
    size_t list_bytes;
} ost_data_names;

typedef struct ost_data_files {
    /* The caller sets the members from `path` to `byte_skip`. */
    const char *path; /* path of the header */
    ost_data_names names;
    ost_data_form form;
    int32_t sizes[3];
    size_t element_bytes;
    uint64_t attached_at; /* offset of the first byte after the header */
    uint64_t line_skip;
    int64_t byte_skip;    /* number of bytes to skip before the data; -1 if the data are the last bytes of the file */

    uint64_t part_bytes;
    /* `pattern` and `pattern_length` are used for numbered files. */
    const char *pattern; /* pattern of the file name; not terminated by NUL */
    size_t pattern_length;
    int64_t first, step;
    uint64_t count;
    /*
     * Used for LIST: position and index of the next name to read. The position is kept between calls, so that opening
     * all files reads the list only once.
     */
    const char *list_at;
    uint64_t list_index;
} ost_data_files;

/* Returns true if the value of a header field begins with the word LIST. value may be NULL. */
bool ost_data_is_list(const char *value);

/* Fills *parts, which refers to *files. *files must therefore outlive *parts. */
ost_status ost_data_files_open(ost_data_files *files, ost_parts *parts, ost_error *err);

#endif
