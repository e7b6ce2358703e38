/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Second pass over a CT text. Stores every sample in its voxel, in batches, through the backend (thesis, Alg. 2.4;
 * docs/spec/arithmetic.md, AR-CT-4 to AR-CT-6).
 */
#ifndef OST_IO_TEXT_RECT_H
#define OST_IO_TEXT_RECT_H

#include "io/text/scan.h"

typedef struct ost_text_rect_options {
    ost_duplicates duplicates;
    const ost_geometry *full;      /* geometry of the complete grid of the text */
    const ost_voxel_box *crop;     /* part of `full` that the rect grid covers; NULL for the complete grid */
    ost_text_fingerprint expected; /* fingerprint that the first pass computed */
    /* line that states the dims, so that every voxel must have a sample; 0 if the text does not state its dims */
    int64_t dims_line;
    ost_progress *progress;        /* progress callback; may be NULL */
    void *user;
} ost_text_rect_options;

/*
 * Rewinds `source` and scatters its samples into `rect`, which must be empty. Returns OST_ERR_INPUT at the first
 * sample that is off the lattice or in conflict with another sample; the message contains the line and the sample's
 * values. Also returns OST_ERR_INPUT if the file has changed since the first pass.
 */
ost_status ost_text_to_rect(ost_text_source *source, const ost_text_rect_options *options, ost_grid *rect,
                            ost_scatter_report *report, ost_error *err);

#endif
