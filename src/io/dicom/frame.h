/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An image as the reader uses it. The decimals of its record (protocol.h) are converted to integers:
 *
 *   lengths      in picometres
 *   directions   in units of 10^-9
 *   rescale      in units of 10^-12
 *
 * Decimals that are not multiples of these units are rounded half to even. During the scan of a folder, a missing or
 * invalid attribute is only recorded in `bad`. It becomes an error when the image's series is read.
 */
#ifndef OST_IO_DICOM_FRAME_H
#define OST_IO_DICOM_FRAME_H

#include <osteon/length.h>

#include "io/dicom/protocol.h"

#define OST_DICOM_UNIT INT64_C(1000000000)            /* the value that represents 1.0 in a component of a direction */
#define OST_DICOM_RESCALE_UNIT INT64_C(1000000000000) /* the value that represents 1.0 in a slope or an intercept */

typedef enum ost_dicom_attribute {
    OST_DICOM_NO_ATTRIBUTE,
    OST_DICOM_POSITION,
    OST_DICOM_ORIENTATION,
    OST_DICOM_SPACING,
    OST_DICOM_SLOPE,
    OST_DICOM_INTERCEPT
} ost_dicom_attribute;

typedef struct ost_dicom_frame {
    uint32_t file;   /* index of the file in the scan */
    uint32_t frame;  /* index of the image in the file */
    uint32_t series; /* index of the series in the scan */
    uint32_t flags;  /* OST_DICOM_IMAGE_... */
    ost_dicom_result result;
    const char *encoding; /* encoding of the pixels, such as "raw" or "JPEG 2000"; a string constant */
    int32_t columns, rows;
    uint8_t bits_allocated, bits_stored, high_bit; /* values above 255 are stored as 255 */
    int32_t padding_first, padding_last;
    uint8_t patient[OST_DICOM_IDENTITY], study[OST_DICOM_IDENTITY], reference[OST_DICOM_IDENTITY];
    ost_dicom_attribute bad;               /* first attribute that is missing or invalid */
    char bad_value[OST_DICOM_DECIMAL];     /* text of the attribute `bad`; "" if the attribute is missing */
    ost_pm position[3];                    /* centre of the first pixel, in LPS */
    int64_t direction[2][3];               /* unit vectors along increasing columns and along increasing rows */
    ost_pm spacing[2];                     /* distance between columns, then distance between rows */
    ost_pm thickness;                      /* slice thickness; 0 if the file does not state it */
    bool rescaled;                         /* true if the file states a slope or an intercept */
    int64_t slope, intercept;
} ost_dicom_frame;

/* Converts a record (the payload of a message) to an image. The strings of the record must end with NUL. */
void ost_dicom_frame_of(const ost_dicom_record *record, ost_dicom_frame *out);

#endif
