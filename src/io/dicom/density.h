/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The densities of pixel cells (AR-DCM-1).
 *
 *   cell of 16 bits --stored bits, sign--> value --padding: -1024--> RHE(value * slope + intercept)
 *
 * A table has the density of every possible cell, so the rule is computed once for all images that share
 * its parameters, and a pixel costs one look-up.
 */
#ifndef OST_IO_DICOM_DENSITY_H
#define OST_IO_DICOM_DENSITY_H

#include <stddef.h>

#include "io/dicom/frame.h"

enum { OST_DICOM_CELLS = 1 << 16, OST_DICOM_AIR = -1024 };

typedef struct ost_dicom_table {
    const ost_dicom_frame *of; /* an image with these parameters; NULL: the table is empty */
    bool clamp;                /* saturate densities beyond int16 */
    int16_t density[OST_DICOM_CELLS];
    uint8_t kind[OST_DICOM_CELLS]; /* CELL_... of density.c; 0: an exact density */
    uint64_t padded, rounded, clamped; /* numbers of pixels, counted by ost_dicom_convert */
} ost_dicom_table;

/* Computes the table for an image, unless it is the same as for the image before it. */
void ost_dicom_table_set(ost_dicom_table *table, const ost_dicom_frame *frame);

/*
 * Converts cells up to the first one whose density is beyond int16. Returns the number converted; if it is
 * less than count, *value is the value of that cell.
 */
size_t ost_dicom_convert(ost_dicom_table *table, const uint16_t *cells, size_t count, int16_t *out, int32_t *value);

#endif
