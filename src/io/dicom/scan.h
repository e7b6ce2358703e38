/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The images in the files of a folder, and their series.
 *
 *   files.c (paths) --request--> osteon-dicom (several processes, each for a part of the files) --records-->
 *       frame.c (exact numbers) --> frames, in the order of the files --> series, in the order of their first image
 *
 * No pixel is read. Images are of one series if their SeriesInstanceUIDs are equal or, in files without
 * one, their studies and SeriesNumbers.
 */
#ifndef OST_IO_DICOM_SCAN_H
#define OST_IO_DICOM_SCAN_H

#include <osteon/io.h>

#include "io/dicom/files.h"
#include "io/dicom/frame.h"
#include "io/dicom/process.h"

enum { OST_DICOM_SERIES_MAX = 1 << 12 };

/* A series as its first image describes it. Texts are printable. */
typedef struct ost_dicom_group {
    char uid[OST_DICOM_TEXT], description[OST_DICOM_TEXT], kernel[OST_DICOM_TEXT], modality[OST_DICOM_TEXT];
    bool numbered;
    int32_t number;
    uint8_t study[OST_DICOM_IDENTITY];
    uint32_t images;     /* images that can be slices: neither localizers nor colour images */
    uint32_t localizers;
} ost_dicom_group;

typedef struct ost_dicom_scan {
    const char *path;          /* the folder or file that was scanned; the caller's */
    ost_dicom_files files;
    ost_dicom_frame *frames;   /* owned */
    size_t frame_count, frame_capacity;
    ost_dicom_group *series;   /* owned */
    size_t series_count, series_capacity;
    uint32_t not_dicom, no_image; /* numbers of files that are ignored */
} ost_dicom_scan;

/* Scans a path. launch->program is not NULL. *out is initialised here and is empty after a failure. */
ost_status ost_dicom_scan_path(const char *path, const ost_dicom_launch *launch, ost_dicom_scan *out, ost_error *err);
void ost_dicom_scan_free(ost_dicom_scan *scan);

/* Adds the image of a record, which came from file `file`. Returns OST_ERR_INPUT if the record is not valid. */
ost_status ost_dicom_scan_add(ost_dicom_scan *scan, size_t file, const ost_dicom_record *record, ost_error *err);

/* Returns the error for a file whose result is not OK. */
ost_status ost_dicom_refuse(const char *file, ost_dicom_result result, ost_error *err);

#endif
