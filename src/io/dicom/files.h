/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the DICOM files to read for a path:
 *
 *   folder      all regular files in the folder and its subfolders, sorted by name
 *   DICOMDIR    the same for the folder that contains the DICOMDIR
 *   other file  only this file
 *
 * Symbolic links inside the folder are not followed, so no file outside the folder is listed.
 */
#ifndef OST_IO_DICOM_FILES_H
#define OST_IO_DICOM_FILES_H

#include <stddef.h>

#include <osteon/status.h>

typedef struct ost_dicom_files {
    size_t count, capacity;
    char **path; /* owned */
} ost_dicom_files;

/* Lists the files of `path`. *out is initialised in all cases and is empty on failure. */
ost_status ost_dicom_files_find(const char *path, ost_dicom_files *out, ost_error *err);
void ost_dicom_files_free(ost_dicom_files *files);

#endif
