/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The files that a path to DICOM stands for: all regular files in a folder and its subfolders, in the
 * order of their names; or the file itself. A DICOMDIR stands for its folder. Symbolic links in the
 * folder are not followed, so the files cannot be outside of it.
 */
#ifndef OST_IO_DICOM_FILES_H
#define OST_IO_DICOM_FILES_H

#include <stddef.h>

#include <osteon/status.h>

typedef struct ost_dicom_files {
    size_t count, capacity;
    char **path; /* owned */
} ost_dicom_files;

/* *out is initialised here and is empty after a failure. */
ost_status ost_dicom_files_find(const char *path, ost_dicom_files *out, ost_error *err);
void ost_dicom_files_free(ost_dicom_files *files);

#endif
