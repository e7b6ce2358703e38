/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stores a list of the unfinished folders and the running workers. When a signal ends
 * this process, the workers are killed and the folders are removed.
 *
 *   signal_cleanup_folder, signal_cleanup_worker --signal--> signal_cleanup_end: workers are
 *                                                killed, folders removed
 *
 * After SIGKILL no handler runs. The system then kills the workers, because their parent ended (worker.c),
 * and deletes the traces, which have no names (scratch.h). The unfinished folder of a bundle remains.
 */
#ifndef OST_VALIDATION_SIGNAL_CLEANUP_H
#define OST_VALIDATION_SIGNAL_CLEANUP_H

#include <sys/types.h>

/* Adds a folder to the list and copies its path. If the list is full or the path is too long, the folder is not added,
   and the signal handler does not remove it. */
void signal_cleanup_folder(const char *path);
void signal_cleanup_folder_gone(const char *path);
/* Removes a folder with its contents, and removes its entry from the list. */
void signal_cleanup_folder_remove(const char *path);
void signal_cleanup_worker(pid_t pid);
void signal_cleanup_worker_gone(pid_t pid);

/* Kills the listed workers and removes the listed folders. Async-signal-safe. Called by a handler that ends the
   process. */
void signal_cleanup_end(void);

#endif
