/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Second pass over a CT text: every sample into its voxel (thesis, Alg. 2.4;
 * docs/arithmetic.md, AR-CT-4 to AR-CT-6), a batch at a time, by the backend.
 */
#ifndef OST_IO_TEXT_RECT_H
#define OST_IO_TEXT_RECT_H

#include "io/text/scan.h"

typedef struct ost_text_rect_options {
    ost_duplicates duplicates;
    const ost_geometry *full;      /* the text's whole grid */
    const ost_voxel_box *crop;     /* NULL: rect is the whole grid; else rect is this part of it */
    ost_text_fingerprint expected; /* what the first pass saw */
    int64_t dims_line;             /* of the text's own dims, by which every voxel has one sample; 0 when it gives none */
    ost_progress *progress;        /* may be NULL */
    void *user;
} ost_text_rect_options;

/*
 * Rewinds source and scatters it into rect, which is empty.  OST_ERR_INPUT
 * with the line and its values at the first sample off the lattice or in
 * conflict with another, and when the file is not the one that was scanned.
 */
ost_status ost_text_to_rect(ost_text_source *source, const ost_text_rect_options *options, ost_grid *rect,
                            ost_scatter_report *report, ost_error *err);

#endif
