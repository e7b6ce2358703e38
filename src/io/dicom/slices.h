/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Produces the slices of a volume from a stack of DICOM images, as rows of densities.
 *
 *   images.c (cells) --density.c--> slice --untilt (AR-DCM-4)--> slice --even (AR-DCM-5)--> rows of the result
 *
 * Without resampling, the cells of a row are converted directly into the result.
 */
#ifndef OST_IO_DICOM_SLICES_H
#define OST_IO_DICOM_SLICES_H

#include "io/dicom/density.h"
#include "io/dicom/images.h"
#include "io/volume/rows.h"

typedef struct ost_dicom_slices {
    ost_rows rows; /* must be the first member, because rows.next casts its address to this struct */
    ost_dicom_images images;
    ost_dicom_table table;
    const ost_dicom_frame *frame; /* image of the slice that was read last */
    const int16_t *current;       /* slice of the result whose rows are being returned; NULL without resampling */
    size_t index;              /* number of stack slices read so far; used only for evened stacks */
    int16_t *plain;            /* owned; a slice that is not yet sheared */
    /* owned; for evened stacks, the two slices that were read last; for stacks that are only untilted, `before` is the
     * slice that was read last, and `after` is NULL */
    int16_t *before, *after;
    int16_t *mixed;            /* owned; interpolated slice of the result, for evened stacks */
    int64_t interpolated;      /* number of slices of the result that were interpolated */
} ost_dicom_slices;

/* Starts reading. *out refers to the stack and may be closed even after a failure. */
ost_status ost_dicom_slices_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, bool clamp,
                                 ost_dicom_slices *out, ost_error *err);
void ost_dicom_slices_close(ost_dicom_slices *slices);

/*
 * Shifts a slice of columns * rows densities by -drift. The result has sizes[0] * sizes[1] pixels, and its first pixel
 * lies `margin` pixels before the first pixel of the slice. Result pixels outside the slice become air.
 */
void ost_dicom_shear(const int16_t *from, int32_t columns, int32_t rows, const ost_pm drift[2], const ost_pm spacing[2],
                     const int32_t margin[2], const int32_t sizes[2], int16_t *to);

/*
 * Interpolates linearly between two slices: computes (before * (gap - part) + after * part) / gap, rounded half to
 * even, for each pixel. `gap` is the distance between the slices, and `part` is the distance of the result from
 * `before`. Requires 0 <= part <= gap < 2^62.
 */
void ost_dicom_mix(const int16_t *before, const int16_t *after, size_t count, int64_t part, int64_t gap, int16_t *to);

#endif
