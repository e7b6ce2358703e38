/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts pixel cells to densities (AR-DCM-1).
 *
 *   cell of 16 bits --stored bits, sign--> value ----> RHE(value * slope + intercept), or -1024 for padding
 *
 * The densities of all 2^16 possible cells are computed in advance and shared by all images with the same parameters,
 * so converting a pixel is one table lookup. RHE rounds half to even.
 */
#ifndef OST_IO_DICOM_DENSITY_H
#define OST_IO_DICOM_DENSITY_H

#include <stddef.h>

#include "io/dicom/frame.h"

enum { OST_DICOM_CELLS = 1 << 16, OST_DICOM_AIR = -1024 };

typedef struct ost_dicom_table {
    const ost_dicom_frame *of; /* the image whose parameters determined the table; NULL if the table is empty */
    /* if true, densities outside the range of int16 are clamped; if false, they are errors */
    bool clamp;
    int16_t density[OST_DICOM_CELLS];
    uint8_t kind[OST_DICOM_CELLS]; /* flags CELL_... (density.c) of each cell; 0 if the density is exact */
    /* numbers of padded, rounded and clamped pixels that ost_dicom_convert has converted */
    uint64_t padded, rounded, clamped;
} ost_dicom_table;

/* Computes the table for an image. Does nothing if the image has the same parameters as the previous one. */
void ost_dicom_table_set(ost_dicom_table *table, const ost_dicom_frame *frame);

/*
 * Converts `count` cells, but stops at the first cell whose density does not fit into int16. Returns the number of
 * converted cells. If this number is less than `count`, *value is the value of the cell that could not be converted.
 */
size_t ost_dicom_convert(ost_dicom_table *table, const uint16_t *cells, size_t count, int16_t *out, int32_t *value);

#endif
