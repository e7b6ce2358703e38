/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a picture of a CT and of the parts that a verb made from it: three planes, a surface and a
 * table.
 *
 *   .--------------------------------------------.
 *   | title                                      |
 *   | axial    | coronal    | sagittal           |   greys of the CT, outlines of the parts,
 *   |          |            |                    |   orientation letters, scale bar
 *   | caption                                    |
 *   | surface of the parts  | table              |
 *   '--------------------------------------------'
 *
 * The picture depends only on its input. In particular, it does not depend on the backend, the number of threads, the
 * machine, or the names of folders.
 */
#ifndef OST_APP_PICTURE_PREVIEW_H
#define OST_APP_PICTURE_PREVIEW_H

#include "app/common/app.h"
#include "app/picture/chart.h"

enum { PREVIEW_WIDTH = 1600, PREVIEW_HEIGHT = 1000 };

/* The row of --preview in a verb's option table. */
#define PREVIEW_OPTION(path)                                                                                         \
    {.name = "preview", .kind = OPTION_OUTPUT, .out = &(path), .value = "FILE.png",                                  \
     .help = "also write a picture of the result: three planes of the CT with outlines, a view of the surface, and " \
             "a table of what was read and what was left out"}

/* The input of a preview. All pointers are borrowed. */
typedef struct preview_input {
    const char *out;         /* path of the verb's output; the picture shows only the file name */
    const ost_volume *ct;    /* densities of the CT; if NULL, the planes show the densities of the parts */
    const ost_volume *parts; /* labels of the CT's voxels, or the densities of a bone with cubic voxels */
    bool labels;             /* true if `parts` contains labels; voxels above 0 then belong to parts */
    int32_t threshold;       /* lowest density of bone */
    bool nearest; /* true if densities are taken from the nearest voxel of the CT; false if they are interpolated */
    bool left_out;           /* true if dense voxels of the CT that belong to no part are shown in a colour */
    bool unoriented; /* true if the directions of the axes are only assumed; no orientation letters are then drawn */
    const ost_meta *meta;    /* facts about the patient: position and axis of the glenoid, and side */
    bool at_given;
    ost_pm3 at; /* position through which the planes pass if the glenoid is not known; used only if at_given is set */
    int threads;
    const chart_table *table;
} preview_input;

/* Draws the preview. The caller owns *out. */
ost_status preview_draw(const preview_input *in, ost_picture *out, ost_error *err);

/* Draws the preview and writes it as a PNG file. */
ost_status preview_write(const preview_input *in, const char *path, ost_error *err);

/*
 * Appends the warnings that the verb has issued so far. If a warning begins with "NAME: ", where NAME is the name of
 * the input, this beginning is omitted.
 */
void preview_add_warnings(const app_state *app, const char *name, chart_table *table);

/* Appends the size of a grid in voxels and in millimetres, and the size of its voxels. */
void preview_add_grid(chart_table *table, const char *key, const ost_geometry *geometry);

#endif
