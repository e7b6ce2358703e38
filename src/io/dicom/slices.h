/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The slices of the result of a stack, as rows of densities.
 *
 *   images.c (cells) --density.c--> slice --untilt (AR-DCM-4)--> slice --even (AR-DCM-5)--> rows of the result
 *
 * Without resampling, a row is converted directly from the cells to its place in the result.
 */
#ifndef OST_IO_DICOM_SLICES_H
#define OST_IO_DICOM_SLICES_H

#include "io/dicom/density.h"
#include "io/dicom/images.h"
#include "io/volume/rows.h"

typedef struct ost_dicom_slices {
    ost_rows rows; /* first, since ost_dicom_slices_row finds its slices by it */
    ost_dicom_images images;
    ost_dicom_table table;
    const ost_dicom_frame *frame; /* image of the slice that was read last */
    const int16_t *current;       /* the slice of the result whose rows are requested; NULL if it is not resampled */
    size_t index;              /* if evened: number of slices that were read */
    int16_t *plain;            /* owned; a slice before it is sheared */
    int16_t *before, *after;   /* owned; if evened: the last two slices that were read; if untilted: before alone */
    int16_t *mixed;            /* owned; if evened: the slice of the result */
    int64_t interpolated;      /* slices of the result that are mixtures */
} ost_dicom_slices;

/* Starts to read. *out is initialised here, uses the stack, and may be closed after a failure. */
ost_status ost_dicom_slices_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, bool clamp,
                                 ost_dicom_slices *out, ost_error *err);
void ost_dicom_slices_close(ost_dicom_slices *slices);

/* Implements ost_rows.next: rows are requested in order. */
ost_status ost_dicom_slices_row(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);

/*
 * Shifts a slice of columns * rows densities back by its drift, into a slice of sizes[0] * sizes[1] whose first
 * pixel lies margin pixels before it. Pixels that are not between pixels of the slice become air.
 */
void ost_dicom_shear(const int16_t *from, int32_t columns, int32_t rows, const ost_pm drift[2], const ost_pm spacing[2],
                     const int32_t margin[2], const int32_t sizes[2], int16_t *to);

/* Computes RHE((before * (gap - part) + after * part) / gap) for every pixel, 0 <= part <= gap < 2^62. */
void ost_dicom_mix(const int16_t *before, const int16_t *after, size_t count, int64_t part, int64_t gap, int16_t *to);

#endif
