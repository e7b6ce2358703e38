/* SPDX-License-Identifier: Apache-2.0 */
/* Refuses grids that are too large for the machine's memory, before any work is spent on them. */
#ifndef OST_IO_VOLUME_MEMORY_H
#define OST_IO_VOLUME_MEMORY_H

#include <osteon/grid.h>

/* Returns the machine's memory in bytes, or DBL_MAX if the system does not report it. */
double ost_machine_memory(void);
/*
 * Returns OST_ERR_MEMORY if int16 voxels of the given dims exceed the machine's memory. `what` is the name of the
 * grid, for the message.
 */
ost_status ost_memory_check(const char *path, const char *what, ost_dims dims, ost_error *err);

#endif
