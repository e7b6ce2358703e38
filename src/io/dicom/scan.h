/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scans the files of a folder for images, and groups the images into series.
 *
 *   files.c (paths) --request--> osteon-dicom (several processes, each for a part of the files) --records-->
 *       frame.c (exact numbers) --> frames, in the order of the files --> series, in the order of their first image
 *
 * No pixels are read. Two images belong to the same series if their SeriesInstanceUIDs are equal or, in files without a
 * SeriesInstanceUID, if both their studies and their SeriesNumbers are equal.
 */
#ifndef OST_IO_DICOM_SCAN_H
#define OST_IO_DICOM_SCAN_H

#include <osteon/io.h>

#include "io/dicom/files.h"
#include "io/dicom/frame.h"
#include "io/dicom/process.h"

enum { OST_DICOM_SERIES_MAX = 1 << 12 };

/* A series, described by its first image. All strings are printable. */
typedef struct ost_dicom_group {
    char uid[OST_DICOM_TEXT], description[OST_DICOM_TEXT], kernel[OST_DICOM_TEXT], modality[OST_DICOM_TEXT];
    bool numbered;
    int32_t number;
    uint8_t study[OST_DICOM_IDENTITY];
    uint32_t images;     /* number of images that can be slices, that is, neither localizers nor colour images */
    uint32_t localizers;
} ost_dicom_group;

typedef struct ost_dicom_scan {
    const char *path;          /* folder or file that was scanned; owned by the caller */
    ost_dicom_files files;
    ost_dicom_frame *frames;   /* owned */
    size_t frame_count, frame_capacity;
    ost_dicom_group *series;   /* owned */
    size_t series_count, series_capacity;
    /* numbers of ignored files: files that are not DICOM, and DICOM files without an image */
    uint32_t not_dicom, no_image;
} ost_dicom_scan;

/* Scans a path. launch->program must not be NULL. *out is initialised in all cases and is empty on failure. */
ost_status ost_dicom_scan_path(const char *path, const ost_dicom_launch *launch, ost_dicom_scan *out, ost_error *err);
void ost_dicom_scan_free(ost_dicom_scan *scan);

/*
 * Adds the image described by `record`. The image was found in file number `file`. Returns OST_ERR_INPUT if the record
 * is invalid.
 */
ost_status ost_dicom_scan_add(ost_dicom_scan *scan, size_t file, const ost_dicom_record *record, ost_error *err);

/* Returns the error for a file whose result is not OK. */
ost_status ost_dicom_refuse(const char *file, ost_dicom_result result, ost_error *err);

#endif
