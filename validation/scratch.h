/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where traces go: under TMPDIR, or /tmp.  A trace that this process alone
 * reads has no name, so that nothing of it is left whatever ends the process:
 *
 *   scratch_file --> descriptor --scratch_name--> "/proc/self/fd/5", to open it by
 */
#ifndef OST_VALIDATION_SCRATCH_H
#define OST_VALIDATION_SCRATCH_H

#include <stdint.h>

#include <osteon/status.h>

enum { SCRATCH_PATH = 512 };

ost_status scratch_make(char path[SCRATCH_PATH], ost_error *err);
/* The folder must be empty by then; "" is allowed. */
void scratch_remove(const char *path);

enum { SCRATCH_NAME = 40 };
/* The caller's to close, and gone with that. */
ost_status scratch_file(int *fd, ost_error *err);
/* As long as the descriptor is open. */
void scratch_name(int fd, char name[SCRATCH_NAME]);

/* OST_ERR_IO naming the folder, what is free there and what is needed. */
ost_status scratch_room(uint64_t bytes, ost_error *err);

#endif
