/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the DICOM files that a path denotes. For a folder, these are all regular files in the folder and its
 * subfolders, in the order of their names. The path of a file denotes this file, and the path of a DICOMDIR denotes
 * its folder. Symbolic links in the folder are not followed, so that no file outside the folder is listed.
 */
#ifndef OST_IO_DICOM_FILES_H
#define OST_IO_DICOM_FILES_H

#include <stddef.h>

#include <osteon/status.h>

typedef struct ost_dicom_files {
    size_t count, capacity;
    char **path; /* owned */
} ost_dicom_files;

/* Lists the files of `path`. The function initialises *out, which is empty after a failure. */
ost_status ost_dicom_files_find(const char *path, ost_dicom_files *out, ost_error *err);
void ost_dicom_files_free(ost_dicom_files *files);

#endif
