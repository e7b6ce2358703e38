/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Arranges the images of a series as the slices of a grid (AR-DCM-2 to AR-DCM-4).
 *
 *   images of a series --checks--> ordered along the normal --> doubled images separated --> affine transform
 *
 *        slice 2   ________          along: distance from the first slice along the normal
 *        slice 1  ________           drift: offset from the first slice perpendicular to the normal
 *        slice 0 ________
 *                --> drift
 *
 * A stack is even if every slice is within d/8 and within 0.1 mm of its position in a stack with the constant distance
 * d. A stack is straight if its drift is at most 1/8 of a pixel. All other stacks are refused unless the options
 * request resampling (slices.c).
 */
#ifndef OST_IO_DICOM_STACK_H
#define OST_IO_DICOM_STACK_H

#include "io/dicom/scan.h"
#include "io/volume/orient.h"

typedef struct ost_dicom_slice {
    size_t image;    /* index in `images` of the slice's first image */
    size_t doubles;  /* number of further images at the same position, which directly follow the first image */
    /* distance from the first slice along the normal; 0 for the first slice, then strictly increasing */
    ost_pm along;
    ost_pm drift[2]; /* offset from the first slice along increasing columns and along increasing rows */
} ost_dicom_slice;

typedef struct ost_dicom_stack {
    const ost_dicom_scan *scan;
    const ost_dicom_group *group;
    const ost_dicom_frame **images; /* owned; the images of the series in the order in which they are read */
    size_t image_count;
    ost_dicom_slice *slices;        /* owned */
    size_t slice_count;
    int32_t sizes[3];               /* sizes of the result before its axes are reordered to LPS */
    ost_affine affine;
    bool evened;                    /* true if the slices are resampled at sizes[2] evenly spaced positions */
    bool untilted;                  /* true if the slices are shifted back by their drift */
    /* for untilted stacks, the number of pixels added before the first column and before the first row */
    int32_t margin[2];
} ost_dicom_stack;

/*
 * Arranges the images of a series as a stack and fills the corresponding fields of *report. `options` may be NULL. *out
 * refers to the scan; it is initialised in all cases and is empty on failure.
 */
ost_status ost_dicom_stack_make(const ost_dicom_scan *scan, size_t series, const ost_volume_options *options,
                                ost_dicom_stack *out, ost_dicom_report *report, ost_error *err);
void ost_dicom_stack_free(ost_dicom_stack *stack);

/* Returns the path of an image's file. */
const char *ost_dicom_path_of(const ost_dicom_stack *stack, const ost_dicom_frame *frame);

#endif
