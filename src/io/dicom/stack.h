/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The slices of a series as a grid (AR-DCM-2 to AR-DCM-4).
 *
 *   images of a series --checks--> ordered along the normal --> doubled ones apart --> affine transform
 *
 *        slice 2   ________          along: distance from the first slice along the normal
 *        slice 1  ________           drift: distance from the first slice's columns and rows
 *        slice 0 ________
 *                --> drift
 *
 * A stack is even if every slice lies within the lesser of d/8 and 0.1 mm of its position at equal
 * distances d, and straight if the drift stays within 1/8 of a pixel. Other stacks are refused unless the
 * options request resampling, which slices.c does.
 */
#ifndef OST_IO_DICOM_STACK_H
#define OST_IO_DICOM_STACK_H

#include "io/dicom/scan.h"
#include "io/volume/orient.h"

typedef struct ost_dicom_slice {
    size_t image;    /* index in the stack's images of the slice's first image */
    size_t doubles;  /* number of further images at the same position, which follow it */
    ost_pm along;    /* position along the normal; 0 for the first slice, then increasing */
    ost_pm drift[2]; /* position along the rows (increasing column) and along the columns */
} ost_dicom_slice;

typedef struct ost_dicom_stack {
    const ost_dicom_scan *scan;
    const ost_dicom_group *group;
    const ost_dicom_frame **images; /* owned; in the order in which they are read */
    size_t image_count;
    ost_dicom_slice *slices;        /* owned */
    size_t slice_count;
    int32_t sizes[3];               /* of the result, before its axes are turned to LPS */
    ost_affine affine;
    bool evened;                    /* the slices are resampled onto sizes[2] even positions */
    bool untilted;                  /* the slices are shifted back by their drift */
    int32_t margin[2];              /* if untilted: pixels added before the first column and row */
} ost_dicom_stack;

/*
 * Makes the stack of a series and sets the fields of report that concern it. options may be NULL. *out is
 * initialised here, uses the scan, and is empty after a failure.
 */
ost_status ost_dicom_stack_make(const ost_dicom_scan *scan, size_t series, const ost_volume_options *options,
                                ost_dicom_stack *out, ost_dicom_report *report, ost_error *err);
void ost_dicom_stack_free(ost_dicom_stack *stack);

/* Returns the path of an image's file. */
const char *ost_dicom_path_of(const ost_dicom_stack *stack, const ost_dicom_frame *frame);

#endif
