/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a file's elements, in the file's order, into a volume in LPS+ order.
 *
 *   parts (bytes) --rows--> int16, one row of the file's first axis --scatter--> volume or slice of a target
 *
 * In addition to the volume, only one row is in memory. An oblique grid is first filled
 * in the file's order and then resampled (volume/resample.h). This needs the memory of
 * both grids, and happens only if the caller has requested resampling.
 */
#ifndef OST_IO_VOLUME_ROWS_H
#define OST_IO_VOLUME_ROWS_H

#include <osteon/io.h>

#include "io/volume/element_table.h"
#include "io/volume/orient.h"
#include "io/volume/parts.h"
#include "io/volume/target.h"

typedef struct ost_rows ost_rows;
struct ost_rows {
    /* Reads the next row of densities. `first` is the index, in the file's order, of the row's first voxel. */
    ost_status (*next)(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
    const char *path; /* path of the header, for messages */
    const ost_volume_options *options; /* used only for progress; may be NULL */
    int32_t sizes[3]; /* sizes in the file's order */
    ost_parts *parts; /* parts from which `next` reads; NULL or empty if `next` does not read from parts */
    ost_converter converter;
    /* The following two fields are set by the functions in this file. */
    void *scratch;            /* one row of elements */
    ost_element_table *table; /* the converter's table; may be NULL */
};

/* Implements ost_rows.next for binary elements. */
ost_status ost_rows_next_binary(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
/* Returns OST_ERR_INPUT. The message states the voxel's number in the file, its position and its defect. */
ost_status ost_rows_bad(const ost_rows *rows, int64_t number, const char *file, const char *location,
                        const ost_bad *bad, ost_error *err);

/*
 * Checks and copies the sizes stated in a header. A size is 1 to OST_DIM_MAX on each axis, and there are at most 2^36
 * voxels.
 */
ost_status ost_rows_sizes(const char *path, const int64_t sizes[3], int32_t out[3], ost_error *err);

/*
 * Determines the directions of the file's axes. Called before ost_volume_resolve. On entry, *oriented is true if the
 * file states the directions; options->orientation must then not be set. Otherwise, the header fact
 * OST_META_ORIENTATION is added to meta. If options->orientation is set, the affine transform is converted from this
 * orientation to LPS, and *oriented is set to true; if not, LPS is assumed (report->assumed).
 */
ost_status ost_volume_orientation(const char *path, const ost_volume_options *options, ost_affine *affine,
                                  bool *oriented, ost_meta *meta, ost_volume_report *report, ost_error *err);

/*
 * Determines the geometry of the result, and fills the fields of the report that concern the geometry. An oblique
 * grid is an error unless the options request resampling.
 */
ost_status ost_volume_resolve(const char *path, const ost_affine *affine, const int32_t sizes[3],
                              const ost_volume_options *options, bool oriented, ost_placement *placement,
                              ost_geometry *geometry, ost_volume_report *report, ost_error *err);

/*
 * Checks the parts, reads every row, and checks that no further data follow. If the target is a volume, initialises it
 * with empty meta. If the target consists of functions, only one slice is in memory at a time, provided that each slice
 * of the result is a slice of the file.
 */
ost_status ost_volume_fill(ost_rows *rows, const ost_affine *affine, const ost_placement *placement,
                           const ost_geometry *geometry, const ost_target *target, ost_error *err);

#endif
