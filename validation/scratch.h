/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes temporary files and folders for traces, under TMPDIR or /tmp. If only this process reads a trace, its
 * file has no name, so that the system deletes the file when the process ends for any reason:
 *
 *   scratch_file --> descriptor --scratch_name--> "/proc/self/fd/5", by which it can be opened
 */
#ifndef OST_VALIDATION_SCRATCH_H
#define OST_VALIDATION_SCRATCH_H

#include <stdint.h>

#include <osteon/status.h>

enum { SCRATCH_PATH = 512 };

ost_status scratch_make(char path[SCRATCH_PATH], ost_error *err);
/* Removes an empty folder that scratch_make made. Does nothing if path is "". */
void scratch_remove(const char *path);

enum { SCRATCH_NAME = 40 };
/* Creates a temporary file without a name, which exists until the caller closes the descriptor. */
ost_status scratch_file(int *fd, ost_error *err);
/* Writes a path by which the file can be opened. The path is valid as long as the descriptor is open. */
void scratch_name(int fd, char name[SCRATCH_NAME]);

/* Returns OST_ERR_IO if fewer than `bytes` bytes are free. The error line contains the folder, the free size and the
   required size. */
ost_status scratch_check_space(uint64_t bytes, ost_error *err);

#endif
