/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An image as the reader uses it: the numbers of a record (protocol.h), read exactly.
 *
 *   lengths      picometres (RHE of the decimal)
 *   directions   integers times 10^-9 (RHE)
 *   rescale      integers times 10^-12 (RHE)
 *
 * An image whose attributes are missing or bad is kept with its defect, because it is an error only if
 * its series is read.
 */
#ifndef OST_IO_DICOM_FRAME_H
#define OST_IO_DICOM_FRAME_H

#include <osteon/length.h>

#include "io/dicom/protocol.h"

#define OST_DICOM_UNIT INT64_C(1000000000)             /* 1 as a direction */
#define OST_DICOM_RESCALE_UNIT INT64_C(1000000000000)  /* 1 as a slope or an intercept */

typedef enum ost_dicom_attribute {
    OST_DICOM_NO_ATTRIBUTE,
    OST_DICOM_POSITION,
    OST_DICOM_ORIENTATION,
    OST_DICOM_SPACING,
    OST_DICOM_SLOPE,
    OST_DICOM_INTERCEPT
} ost_dicom_attribute;

typedef struct ost_dicom_frame {
    uint32_t file;   /* index in the files of the scan */
    uint32_t frame;  /* index in the file */
    uint32_t series; /* index in the series of the scan */
    uint32_t flags;  /* OST_DICOM_IMAGE_... */
    ost_dicom_result result;
    const char *encoding; /* of the pixels, such as "raw" or "JPEG 2000"; a constant */
    int32_t columns, rows;
    uint8_t bits_allocated, bits_stored, high_bit; /* 255 for any larger number */
    int32_t padding_first, padding_last;
    uint8_t patient[OST_DICOM_IDENTITY], study[OST_DICOM_IDENTITY], reference[OST_DICOM_IDENTITY];
    ost_dicom_attribute bad;               /* the first attribute that is missing or bad */
    char bad_value[OST_DICOM_DECIMAL];     /* its value; "" if it is missing */
    ost_pm position[3];                    /* centre of the first pixel, LPS */
    int64_t direction[2][3];               /* of increasing column and of increasing row */
    ost_pm spacing[2];                     /* between columns, between rows */
    ost_pm thickness;                      /* 0: not stated */
    bool rescaled;                         /* the file states slope and intercept */
    int64_t slope, intercept;
} ost_dicom_frame;

/* Converts the numbers of a record. `record` is the payload of a message, whose texts are terminated. */
void ost_dicom_frame_of(const ost_dicom_record *record, ost_dicom_frame *out);

#endif
