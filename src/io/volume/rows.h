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

#include "io/volume/element.h"
#include "io/volume/orient.h"
#include "io/volume/parts.h"
#include "io/volume/target.h"

typedef struct ost_rows ost_rows;
struct ost_rows {
    /* Reads the next row of densities; `first` is the number of its first voxel in the file. */
    ost_status (*next)(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
    const char *path; /* path of the header, for messages */
    const ost_volume_options *options; /* for progress; may be NULL */
    int32_t sizes[3]; /* sizes in the file's order */
    ost_parts *parts; /* NULL if `next` reads from elsewhere */
    ost_converter converter;
    void *scratch; /* one row of elements; set by the functions of this file */
};

/* Implements `next` for binary elements. */
ost_status ost_rows_next_binary(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
/*
 * Returns OST_ERR_INPUT with a message that names voxel `number` of the file, its position in the file and its defect.
 */
ost_status ost_rows_bad(const ost_rows *rows, int64_t number, const char *file, const char *location,
                        const ost_bad *bad, ost_error *err);

/* Checks and copies the sizes from a header: 1 to OST_DIM_MAX on each axis and at most 2^36 voxels in all. */
ost_status ost_rows_sizes(const char *path, const int64_t sizes[3], int32_t out[3], ost_error *err);

/*
 * Determines the directions of the file's axes, before ost_volume_resolve. *oriented
 * is true if the file states them. If it does not, the affine is converted to LPS
 * by options->orientation, or is assumed to be LPS (report->assumed); the fact
 * OST_META_ORIENTATION is then added to meta. It is an error if both the file and
 * the option state the orientation.
 */
ost_status ost_volume_orientation(const char *path, const ost_volume_options *options, ost_affine *affine,
                                  bool *oriented, ost_meta *meta, ost_volume_report *report, ost_error *err);

/*
 * Determines the geometry of the result. An oblique grid is an error unless the options request resampling. Fills the
 * fields of report that concern the geometry.
 */
ost_status ost_volume_resolve(const char *path, const ost_affine *affine, const int32_t sizes[3],
                              const ost_volume_options *options, bool oriented, ost_placement *placement,
                              ost_geometry *geometry, ost_volume_report *report, ost_error *err);

/*
 * Checks the parts, reads every row, and checks that no further data follow. A volume of the target is initialised
 * here; its meta is empty. For a target of functions, if the slices of the result are slices of the file, only one
 * slice is in memory.
 */
ost_status ost_volume_fill(ost_rows *rows, const ost_affine *affine, const ost_placement *placement,
                           const ost_geometry *geometry, const ost_target *target, ost_error *err);

#endif
