/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the files of a stack in slice order (AR-FILE-9).
 *
 *   FOLDER         all regular files in the folder, except hidden files; subfolders are ignored
 *   FOLDER/a*.tif  the files whose names match the shell pattern in the last part of the path
 *   FILE           one file
 *
 * The names must be alike, that is, they may differ in one number only. This number orders the slices:
 *
 *   s1_bc_0009.tif, s1_bc_0010.tif       9, 10
 *   s1_bc_9.tif,    s1_bc_10.tif         9, 10
 *   s1_bc_0009.tif, s2_bc_0010.tif       refused: two numbers differ
 *   s1_bc_0009.tif, s1_bc_0011.tif       refused: 10 is missing
 */
#ifndef OST_IO_STACK_NAMES_H
#define OST_IO_STACK_NAMES_H

#include <stdbool.h>
#include <stddef.h>

#include <osteon/status.h>

typedef struct ost_stack_names {
    size_t count;
    char **paths; /* owned */
} ost_stack_names;

/* Returns true if the last part of the path contains '*' and no file has this path. */
bool ost_stack_is_pattern(const char *path);

/* Lists the files of a stack. On failure, *out is empty. */
ost_status ost_stack_names_read(const char *path, ost_stack_names *out, ost_error *err);
void ost_stack_names_free(ost_stack_names *names);

/*
 * Sets *is to true if the path denotes a stack: a pattern, or a folder in which all regular files are TIFF or PNG
 * files, judging by their first bytes. Stops at the first file of another type.
 */
ost_status ost_stack_find(const char *path, bool *is, ost_error *err);

#endif
