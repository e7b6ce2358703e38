/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CT text that is a scan: every voxel of a box has its line, in order.
 *
 *   # comments, a header                       the head, read line by line
 *   x0 y0 z0 d   x1 y0 z0 d  ...               the columns: x0, x1, ...
 *   x0 y1 z0 d   ...                           the middle axis: y0, y1, ...
 *   ...
 *   x0 y0 z1 d   ...                           the slow axis: z0, z1, ...
 *
 * Most texts are scans, and a scan is known by its coordinates along each
 * axis: every line has one place, which its position in the file must
 * confirm.  So one pass is enough, by all threads, each over its pieces of the
 * file, and almost every line is compared instead of parsed (match.h).
 *
 * What is not a scan to the last line is `found` to be none, whatever it is
 * instead, a broken text among others; nothing has happened then, and the
 * readers of text_scan.h and text_rect.h say what there is to say.  What is
 * one gives, to the bit, what they give.  The axes may run in any order and
 * either direction.
 *
 * Memory: two bytes a line, which are a voxel of the grid each, and a buffer a
 * thread.
 */
#ifndef OST_IO_TEXT_RASTER_H
#define OST_IO_TEXT_RASTER_H

#include "io/text/rect.h"

typedef struct ost_text_raster_options {
    ost_pm3 given;          /* as for ost_text_scan */
    int threads;            /* 0 = all */
    ost_progress *progress; /* may be NULL; stage "samples" */
    void *user;
} ost_text_raster_options;

/* By rank: 0 is the axis that runs fastest. */
typedef struct ost_text_raster {
    int axis[3];       /* 0 x, 1 y, 2 z */
    int32_t count[3];  /* 1 <= count <= OST_DIM_MAX */
    ost_pm *at[3];     /* owned; count coordinates, strictly ascending or descending */
    int64_t first_line;
    int16_t *voxels;   /* owned; the densities in the file's order */
    size_t voxel_bytes;
} ost_text_raster;

/*
 * *found: the text is a scan, its summary is what ost_text_scan makes of it
 * (but for the fingerprint's hash), its geometry is sound, and every sample
 * has a voxel of its own.  The summary is to be freed then, and the raster.
 * OST_ERR_CANCELLED is the only error: any other is left to be met again.
 */
ost_status ost_text_raster_read(const char *path, const ost_text_raster_options *options, ost_text_summary *summary,
                                ost_text_raster *raster, bool *found, ost_error *err);
void ost_text_raster_free(ost_text_raster *raster);

/* What ost_text_scan gives its hasher. */
ost_status ost_text_raster_hash(const ost_text_raster *raster, ost_hasher *hasher, ost_error *err);

/* As ost_text_to_rect, whose reports it makes; options->expected is not looked at. */
ost_status ost_text_raster_to_rect(const char *path, const ost_text_raster *raster, const ost_text_rect_options *options, ost_grid *rect,
                                   ost_scatter_report *report, ost_error *err);

#endif
