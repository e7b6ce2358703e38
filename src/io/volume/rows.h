/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a file's elements, in the file's order, to a volume in LPS+ order.
 *
 *   parts (bytes) --rows--> int16, one row of the file's first axis --scatter--> volume
 *
 * One row is in memory beside the volume.  An oblique grid is first filled as
 * the file has it and then resampled (volume_resample.h): twice the memory of
 * its grid, only where that was asked for.
 */
#ifndef OST_IO_VOLUME_ROWS_H
#define OST_IO_VOLUME_ROWS_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/orient.h"
#include "io/volume/parts.h"

typedef struct ost_rows ost_rows;
struct ost_rows {
    /* The next row of densities; `first` is its first voxel's number in the file. */
    ost_status (*next)(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
    const char *path; /* of the header, for messages */
    int32_t sizes[3]; /* in the file's order */
    ost_parts *parts;
    ost_converter converter;
    void *scratch; /* one row of elements; kept by the functions */
};

/* Rows of binary elements. */
ost_status ost_rows_next_binary(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
/* OST_ERR_INPUT that names voxel `number` of the file, where it stands, and what is wrong with it. */
ost_status ost_rows_bad(const ost_rows *rows, int64_t number, const char *file, const char *place, const ost_bad *bad, ost_error *err);

/* sizes from a header: 1..OST_DIM_MAX an axis and at most 2^36 in all. */
ost_status ost_rows_sizes(const char *path, const int64_t sizes[3], int32_t out[3], ost_error *err);

/*
 * Settles where the file's axes point, before ost_volume_settle. *oriented is
 * true when the file states it. If it does not, the affine is taken to LPS by
 * options->orientation, or is assumed to be LPS (report->assumed); the fact is
 * added to meta as OST_META_ORIENTATION. A file that states its orientation
 * and an option that does so too are an error.
 */
ost_status ost_volume_orientation(const char *path, const ost_volume_options *options, ost_affine *affine, bool *oriented, ost_meta *meta,
                                  ost_volume_report *report, ost_error *err);

/* The grid that results, once options were heard about an oblique one; report is filled as far as geometry goes. */
ost_status ost_volume_settle(const char *path, const ost_affine *affine, const int32_t sizes[3], const ost_volume_options *options,
                             bool oriented, ost_placement *placement, ost_geometry *geometry, ost_volume_report *report,
                             ost_error *err);

/* Checks the parts, allocates, reads every row, ends the parts. *out is initialised here; its meta is empty. */
ost_status ost_volume_fill(ost_rows *rows, const ost_affine *affine, const ost_placement *placement, const ost_geometry *geometry,
                           ost_volume *out, ost_error *err);

#endif
