/* SPDX-License-Identifier: Apache-2.0 */
/*
 * First pass over a CT text. Collects all information that does not require a grid (thesis, Alg. 2.3;
 * docs/spec/arithmetic.md, AR-CT-3).
 *
 *   file --ost_text_scan--> extent, distinct coordinates, facts, fingerprint
 *        --ost_text_geometry--> dims, spacing, origin
 *
 * Memory: a read buffer and at most OST_DIM_MAX coordinates per axis, for files of
 * any size.
 */
#ifndef OST_IO_TEXT_SCAN_H
#define OST_IO_TEXT_SCAN_H

#include <osteon/io.h>

#include "io/text/parse.h"

/* --------------------------------------- a rewindable source of rows */

typedef struct ost_text_source {
    ost_text_lines *lines;
    ost_text_block block;
    ost_text_parser parser;
} ost_text_source;

ost_status ost_text_source_open(ost_text_source *source, const char *path, ost_error *err);
/* Reads the next rows. At the end of the file, sets *count to 0. */
ost_status ost_text_source_next(ost_text_source *source, ost_text_row *rows, size_t capacity, size_t *count,
                                ost_error *err);
ost_status ost_text_source_rewind(ost_text_source *source, ost_error *err);
void ost_text_source_close(ost_text_source *source);

/*
 * A fingerprint of the rows and their order. It shows whether the file has changed between two passes. The hash need
 * not be cryptographic, because nobody has a reason to construct a collision.
 */
typedef struct ost_text_fingerprint {
    uint64_t rows, hash;
} ost_text_fingerprint;
void ost_text_fingerprint_add(ost_text_fingerprint *fingerprint, const ost_text_row *rows, size_t count);

/* --------------------------------------------------------------- the summary */

typedef struct ost_text_coordinate {
    ost_pm value;
    int64_t line; /* line in which the coordinate occurs first; 0 marks a free entry of the hash set */
} ost_text_coordinate;

typedef struct ost_text_axis {
    ost_pm min, max;
    ost_pm given;       /* spacing from an option or from the text itself; 0 if it must be determined */
    uint32_t units;     /* ost_lattice_axis explains `units` and `rounded` */
    bool rounded;
    size_t distinct;    /* number of coordinates in `set`, which is sorted after the pass */
    ost_text_coordinate *set;
} ost_text_axis;

/* Three values that the text states in a header fact (AR-CT-8). */
typedef struct ost_text_own {
    int64_t line; /* first line that states the values; 0 if no line states them */
    int64_t value[3];
} ost_text_own;

typedef struct ost_text_summary {
    ost_text_axis axis[3];
    ost_text_fingerprint fingerprint;
    uint64_t rounded_positions;
    ost_meta meta;
    ost_text_own own_spacing, own_origin; /* header facts "spacing_mm" and "origin_mm", in picometres */
    ost_text_own own_dims;                /* header fact "dims"; a text with this fact has one line for every voxel */
} ost_text_summary;

/*
 * Initialises an empty summary with the spacings from the options. The summary must later be freed, even after an
 * error.
 */
void ost_text_summary_begin(ost_text_summary *summary, ost_pm3 given);
/*
 * User data of ost_text_fact_take. The parser calls this function for each header fact; the function stores the fact in
 * the summary.
 */
typedef struct ost_text_facts {
    ost_text_summary *summary;
    ost_pm3 given;
} ost_text_facts;
ost_status ost_text_fact_take(void *facts, const ost_text_parser *parser, const ost_text_fact *fact, ost_error *err);

/*
 * Scans the text. A nonzero spacing in `given` comes from an option and overrides the spacing in the text. If `hasher`
 * is not NULL, a record of 32 bytes per sample is added to it: x, y, z as int64, density as int32, 0 as uint32,
 * little-endian. progress may be NULL. The caller frees the summary, even after an error.
 */
ost_status ost_text_scan(ost_text_source *source, ost_pm3 given, ost_hasher *hasher, ost_progress *progress, void *user,
                         ost_text_summary *summary, ost_error *err);
void ost_text_summary_free(ost_text_summary *summary);

/* Computes the geometry. inferred[a] is set to true if the spacing of axis a was found from the coordinates. */
ost_status ost_text_geometry(const char *path, const ost_text_summary *summary, ost_geometry *out, bool inferred[3],
                             ost_error *err);

#endif
