/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What must not outlive this process when a signal ends it: folders that are
 * being filled, and workers.
 *
 *   leftover_folder, leftover_worker --signal--> leftover_end: workers are
 *                                                killed, folders removed
 *
 * A SIGKILL runs nothing.  Workers end with it all the same, since they ask
 * the system to be ended when their parent is (worker.c), and traces have no
 * names (scratch.h); a bundle's unfinished folder stays.
 */
#ifndef OST_VALIDATION_LEFTOVER_H
#define OST_VALIDATION_LEFTOVER_H

#include <sys/types.h>

/* Of more than a few nothing is noted: they stay. path is copied. */
void leftover_folder(const char *path);
void leftover_folder_gone(const char *path);
/* Removes a listed folder with all that is in it. */
void leftover_folder_remove(const char *path);
void leftover_worker(pid_t pid);
void leftover_worker_gone(pid_t pid);

/* Async-signal-safe; for a handler that ends the process. */
void leftover_end(void);

#endif
