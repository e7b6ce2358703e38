/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a stack of grey slices: a folder of TIFF or PNG files, or one TIFF file whose pages are the slices.
 *
 *   pass 1   every slice is opened; its size, type and number of pages are compared with those of the first
 *   pass 2   the grid is allocated, and the slices are read row by row
 *
 * A stack states neither its spacing nor its orientation, so the spacing is an option. Resolution tags are only
 * reported, because most programs write 72 dpi or another meaningless value. The three axes of the file are the
 * columns, the rows from the top, and the slices. The first pixel of the first slice is at position 0 (AR-FILE-9).
 */
#ifndef OST_IO_STACK_READ_H
#define OST_IO_STACK_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/target.h"

/*
 * Reads a stack. `path` is a folder, a pattern or a file. For the other parameters, see ost_volume_read_any
 * (volume_read.h).
 */
ost_status ost_stack_read(const char *path, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                          ost_error *err);

/* Properties of a stack, as stated in its files. */
typedef struct ost_stack_facts {
    ost_dims dims; /* number of columns, rows and slices */
    char type[24], encoding[16];
    double pixel_mm[2]; /* pixel size in mm as stated by the first slice; 0 if the slice states none */
} ost_stack_facts;

/* Describes a stack without reading its pixels. */
ost_status ost_stack_describe(const char *path, ost_stack_facts *out, ost_error *err);

#endif
