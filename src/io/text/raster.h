/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a CT text that is a raster scan: every voxel of a box has exactly one line,
 * in order.
 *
 *   # comments, a header                       the head, read line by line
 *   x0 y0 z0 d   x1 y0 z0 d  ...               the columns: x0, x1, ...
 *   x0 y1 z0 d   ...                           the middle axis: y0, y1, ...
 *   ...
 *   x0 y0 z1 d   ...                           the slow axis: z0, z1, ...
 *
 * Most texts are raster scans. A scan is determined by its coordinates along each
 * axis: every line has one voxel, which must agree with the line's offset in the
 * file. One pass is therefore sufficient. Each thread processes its own pieces of
 * the file, and almost every line is compared instead of parsed (match.h).
 *
 * If any line deviates from a scan for any reason, including a defective text,
 * *found is false and there is no other effect. The readers of scan.h and rect.h
 * then read the text and report its errors. For a scan the result is bit-identical
 * to theirs. The axes may run in any order and either direction.
 *
 * Memory: two bytes per line (that is, per voxel of the grid) and one buffer per
 * thread.
 */
#ifndef OST_IO_TEXT_RASTER_H
#define OST_IO_TEXT_RASTER_H

#include "io/text/rect.h"

typedef struct ost_text_raster_options {
    ost_pm3 given;          /* spacings given by options, with the same meaning as in ost_text_scan */
    int threads;            /* 0 = all */
    ost_progress *progress; /* reports the stage "samples"; may be NULL */
    void *user;
} ost_text_raster_options;

/* Arrays are indexed by rank: 0 is the axis that runs fastest. */
typedef struct ost_text_raster {
    int axis[3];       /* 0 is x, 1 is y, 2 is z */
    int32_t count[3];  /* 1 <= count <= OST_DIM_MAX */
    ost_pm *at[3];     /* owned; count coordinates, strictly ascending or descending */
    int64_t first_line;
    int16_t *voxels;   /* owned; the densities in the file's order */
    size_t voxel_bytes;
} ost_text_raster;

/* Returns the number of lines between two neighbours along the axis of this rank. */
static inline int64_t ost_text_raster_stride(const ost_text_raster *raster, int rank)
{
    return rank == 0 ? 1 : rank == 1 ? raster->count[0] : (int64_t)raster->count[0] * raster->count[1];
}

/*
 * Sets *found if the text is a scan, its geometry is valid, and every sample has a
 * voxel of its own. The summary then equals that of ost_text_scan (except for the
 * fingerprint's hash); the caller frees summary and raster.  Apart from the errors of
 * opening the file, OST_ERR_CANCELLED is the only error: all others are reported by
 * the two-pass readers.
 */
ost_status ost_text_raster_read(const char *path, const ost_text_raster_options *options, ost_text_summary *summary,
                                ost_text_raster *raster, bool *found, ost_error *err);
void ost_text_raster_free(ost_text_raster *raster);

/* Adds to the hasher the same bytes as ost_text_scan adds. */
ost_status ost_text_raster_hash(const ost_text_raster *raster, ost_hasher *hasher, ost_error *err);

/*
 * Returns true if every sample has a voxel of its own in the grid. Also returns false if memory cannot be allocated.
 * Defined in raster_rect.c.
 */
bool ost_text_raster_fits(const ost_text_raster *raster, const ost_geometry *full);
/* Fills rect as ost_text_to_rect does, with the same report; options->expected is not used. */
ost_status ost_text_raster_to_rect(const char *path, const ost_text_raster *raster,
                                   const ost_text_rect_options *options, ost_grid *rect, ost_scatter_report *report,
                                   ost_error *err);

#endif
