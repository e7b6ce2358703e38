/* SPDX-License-Identifier: Apache-2.0 */
/* A folder for traces, under TMPDIR or /tmp, for one run. */
#ifndef OST_VALIDATION_SCRATCH_H
#define OST_VALIDATION_SCRATCH_H

#include <osteon/status.h>

enum { SCRATCH_PATH = 512 };

ost_status scratch_make(char path[SCRATCH_PATH], ost_error *err);
/* The folder must be empty by then; "" is allowed. */
void scratch_remove(const char *path);

#endif
