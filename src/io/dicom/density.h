/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts pixel cells to densities (AR-DCM-1).
 *
 *   cell of 16 bits --stored bits, sign--> value --padding: -1024--> RHE(value * slope + intercept)
 *
 * A table contains the density of every possible cell. The rule is therefore computed only once for all images with
 * the same parameters, and a pixel costs one table lookup.
 */
#ifndef OST_IO_DICOM_DENSITY_H
#define OST_IO_DICOM_DENSITY_H

#include <stddef.h>

#include "io/dicom/frame.h"

enum { OST_DICOM_CELLS = 1 << 16, OST_DICOM_AIR = -1024 };

typedef struct ost_dicom_table {
    const ost_dicom_frame *of; /* the image whose parameters determined the table; NULL if the table is empty */
    bool clamp;                /* true if densities beyond int16 are saturated */
    int16_t density[OST_DICOM_CELLS];
    uint8_t kind[OST_DICOM_CELLS]; /* CELL_... of density.c for each cell value; 0 means an exact density */
    uint64_t padded, rounded, clamped; /* numbers of padded, rounded and clamped pixels, counted by ost_dicom_convert */
} ost_dicom_table;

/*
 * Computes the table for an image. If the image has the parameters of the previous image, the table remains
 * unchanged.
 */
void ost_dicom_table_set(ost_dicom_table *table, const ost_dicom_frame *frame);

/*
 * Converts cells up to the first cell whose density is beyond int16. Returns the number of converted cells. If this
 * number is less than count, *value is the value of the cell at which the conversion stopped.
 */
size_t ost_dicom_convert(ost_dicom_table *table, const uint16_t *cells, size_t count, int16_t *out, int32_t *value);

#endif
