/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The files of a stack in the order of their slices (AR-FILE-9).
 *
 *   FOLDER         its regular files; hidden files and folders in it are ignored
 *   FOLDER/a*.tif  those whose names match the shell pattern in the last part of the path
 *   FILE           one file
 *
 * Names are alike if they differ only in one number, which orders the slices:
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

/* Returns true if no file has this name and the last part of the path is a pattern with '*'. */
bool ost_stack_is_pattern(const char *path);

/* Lists the files of a stack. *out is empty on failure. */
ost_status ost_stack_names_read(const char *path, ost_stack_names *out, ost_error *err);
void ost_stack_names_free(ost_stack_names *names);

/*
 * Sets *is to true if the path is a pattern, or a folder all of whose regular files are TIFF or PNG by
 * their first bytes. The search ends at the first other file.
 */
ost_status ost_stack_find(const char *path, bool *is, ost_error *err);

#endif
