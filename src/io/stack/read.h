/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a stack: grey slices as a folder of TIFF or PNG files, or as the pages of one TIFF.
 *
 *   pass 1   every slice is opened and compared with the first: size, type, number of pages
 *   pass 2   the grid is allocated, and the slices are read row by row
 *
 * A stack states neither its spacing nor its orientation. The spacing is an option; resolution tags are
 * only reported, because most programs write 72 dpi or another meaningless value. The columns, the rows
 * from the top and the slices in their order are the three axes of the file, and the first pixel of the
 * first slice is at 0 (AR-FILE-9).
 */
#ifndef OST_IO_STACK_READ_H
#define OST_IO_STACK_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/target.h"

/* The parameters are those of ost_volume_read_any (volume_read.h). path is a folder, a pattern or a file. */
ost_status ost_stack_read(const char *path, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                          ost_error *err);

/* The properties that the slices themselves state. */
typedef struct ost_stack_facts {
    ost_dims dims; /* columns, rows, slices */
    char type[24], encoding[16];
    double pixel_mm[2]; /* size of a pixel that the first slice states; 0: none */
} ost_stack_facts;

/* Describes a stack without reading its pixels. */
ost_status ost_stack_describe(const char *path, ost_stack_facts *out, ost_error *err);

#endif
