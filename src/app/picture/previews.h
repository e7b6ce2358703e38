/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the previews of `osteon import` and `osteon segment`, and writes the rows of their tables. */
#ifndef OST_APP_PICTURE_PREVIEWS_H
#define OST_APP_PICTURE_PREVIEWS_H

#include <osteon/segment.h>

#include "app/input/load.h"
#include "app/picture/preview.h"

/*
 * Checks the file name of a preview, and checks that pictures can be written. The file name may be NULL. Begins to
 * record warnings. Called before any work is done.
 */
ost_status preview_check(app_state *app, const char *path, ost_error *err);

/*
 * Writes the picture of an import: the CT `name`, which was read with the options `ct`, and the bone that was made from
 * it. `out` is the name of the bone's file. If the CT is a text file, the picture shows the densities of the bone. A
 * CT in any other format is read again.
 */
ost_status preview_import(const app_state *app, const char *path, const char *name, const char *out,
                          const ct_options *ct, const ost_bone *bone, const ost_import_result *result,
                          ost_error *err);

/* The inputs of preview_segment. All pointers are borrowed. */
typedef struct preview_labels {
    const char *name, *out;          /* file names of the CT and of the labels */
    /* In labels->meta, the facts whose keys begin with "segment_" describe the options of the segmentation. */
    const ost_volume *ct, *labels;
    const ost_volume_report *report; /* describes how the CT was read */
    const ost_segment *segments;
    size_t count;
    int32_t threshold;
    bool at_given;
    ost_pm3 at;                      /* the position at which the planes meet, if at_given is set */
} preview_labels;

/* Writes the picture of a segmentation. */
ost_status preview_segment(const app_state *app, const char *path, const preview_labels *in, ost_error *err);

#endif
