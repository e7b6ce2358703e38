/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a CT text that is a raster scan, that is, a text with exactly one line for every voxel of a box, in order.
 *
 *   # comments, a header                       the head, read line by line
 *   x0 y0 z0 d   x1 y0 z0 d  ...               the columns: x0, x1, ...
 *   x0 y1 z0 d   ...                           the middle axis: y0, y1, ...
 *   ...
 *   x0 y0 z1 d   ...                           the slow axis: z0, z1, ...
 *
 * Most texts are raster scans. The coordinates along each axis determine the complete scan: the voxel of a line follows
 * from the number of the line. One pass is therefore sufficient. Each thread processes its own pieces of the file, and
 * almost every line is compared instead of parsed (match.h).
 *
 * If any line deviates from a scan, for example in a defective text, the reader sets *found to false and has no other
 * effect. The two-pass readers, scan.h and rect.h, then read the text and report its errors. For a scan, all readers
 * produce bit-identical results. The axes may be in any order, and each axis may ascend or descend.
 *
 * Memory: two bytes per line (that is, per voxel of the grid) and one buffer per thread.
 */
#ifndef OST_IO_TEXT_RASTER_H
#define OST_IO_TEXT_RASTER_H

#include "io/text/rect.h"

typedef struct ost_text_raster_options {
    ost_pm3 given;          /* spacings from options, as for ost_text_scan */
    int threads;            /* number of threads; 0 means all */
    ost_progress *progress; /* progress callback for the stage "samples"; may be NULL */
    void *user;
} ost_text_raster_options;

/* The axes and voxels of a raster scan. Arrays are indexed by rank; rank 0 is the axis that runs fastest. */
typedef struct ost_text_raster {
    int axis[3];       /* the axis of each rank: 0 is x, 1 is y, 2 is z */
    int32_t count[3];  /* number of coordinates of each axis, 1 <= count <= OST_DIM_MAX */
    ost_pm *at[3];     /* owned; `count` coordinates of each axis, strictly ascending or descending */
    int64_t first_line;
    int16_t *voxels;   /* owned; densities in the order of the file */
    size_t voxel_bytes;
} ost_text_raster;

/* Returns the number of lines from one voxel to the next along the axis of the given rank. */
static inline int64_t ost_text_raster_stride(const ost_text_raster *raster, int rank)
{
    return rank == 0 ? 1 : rank == 1 ? raster->count[0] : (int64_t)raster->count[0] * raster->count[1];
}

/*
 * Sets *found to true if the text is a scan, its geometry is valid, and every sample has a voxel of its own. The
 * summary then equals the summary of ost_text_scan, except for the fingerprint's hash. The caller frees the summary and
 * the raster. The only errors are failures to open the file and OST_ERR_CANCELLED; all other errors are left to the
 * two-pass readers.
 */
ost_status ost_text_raster_read(const char *path, const ost_text_raster_options *options, ost_text_summary *summary,
                                ost_text_raster *raster, bool *found, ost_error *err);
void ost_text_raster_free(ost_text_raster *raster);

/* Adds the same bytes to the hasher as ost_text_scan would. */
ost_status ost_text_raster_hash(const ost_text_raster *raster, ost_hasher *hasher, ost_error *err);

/*
 * Returns true if every sample has a voxel of its own in the grid; false if not, or if memory is exhausted. Defined in
 * raster_rect.c.
 */
bool ost_text_raster_fits(const ost_text_raster *raster, const ost_geometry *full);
/* Fills *rect and the report as ost_text_to_rect does. options->expected is not used. */
ost_status ost_text_raster_to_rect(const char *path, const ost_text_raster *raster,
                                   const ost_text_rect_options *options, ost_grid *rect, ost_scatter_report *report,
                                   ost_error *err);

#endif
