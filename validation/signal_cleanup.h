/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists what has to be cleaned up when a signal ends this process: folders that
 * are being filled, and workers.
 *
 *   signal_cleanup_folder, signal_cleanup_worker --signal--> signal_cleanup_end: workers are
 *                                                killed, folders removed
 *
 * SIGKILL runs no handler.  Workers end in that case too, since the system
 * kills them when their parent ends (worker.c), and traces have no names
 * (scratch.h); the unfinished folder of a bundle remains.
 */
#ifndef OST_VALIDATION_SIGNAL_CLEANUP_H
#define OST_VALIDATION_SIGNAL_CLEANUP_H

#include <sys/types.h>

/* Adds a folder to the list; path is copied. If the list is full or the path is too long, the folder is not listed
   and a signal does not remove it. */
void signal_cleanup_folder(const char *path);
void signal_cleanup_folder_gone(const char *path);
/* Removes a listed folder with its contents, and its entry in the list. */
void signal_cleanup_folder_remove(const char *path);
void signal_cleanup_worker(pid_t pid);
void signal_cleanup_worker_gone(pid_t pid);

/* Kills the listed workers and removes the listed folders. Async-signal-safe; for a handler that ends the process. */
void signal_cleanup_end(void);

#endif
