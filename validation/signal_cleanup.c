/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/signal_cleanup.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

enum { FOLDERS = 4, WORKERS = 256, PATH = 1200, DEPTH = 4, TRIES = 3 };

/* States of a slot. The signal handler reads a slot only in the state LISTED, which is set after the path is
   complete. */
enum { FREE, TAKEN, LISTED };
static struct {
    atomic_int state;
    char path[PATH];
} folders[FOLDERS];
static _Atomic pid_t workers[WORKERS]; /* process ids of running workers; 0 marks a free element */

void signal_cleanup_folder(const char *path)
{
    for (int i = 0; i < FOLDERS; i++) {
        int expected = FREE;
        if (!atomic_compare_exchange_strong(&folders[i].state, &expected, TAKEN))
            continue;
        const int n = snprintf(folders[i].path, PATH, "%s", path);
        atomic_store(&folders[i].state, n > 0 && n < PATH ? LISTED : FREE);
        return;
    }
}

void signal_cleanup_folder_gone(const char *path)
{
    for (int i = 0; i < FOLDERS; i++)
        if (atomic_load(&folders[i].state) == LISTED && strcmp(folders[i].path, path) == 0)
            atomic_store(&folders[i].state, FREE);
}

void signal_cleanup_worker(pid_t pid)
{
    for (int i = 0; i < WORKERS; i++) {
        pid_t expected = 0;
        if (atomic_compare_exchange_strong(&workers[i], &expected, pid))
            return;
    }
}

void signal_cleanup_worker_gone(pid_t pid)
{
    for (int i = 0; i < WORKERS; i++) {
        pid_t expected = pid;
        if (atomic_compare_exchange_strong(&workers[i], &expected, 0))
            return;
    }
}

/* Removes the contents of an open folder. Reads the entries with a system call, because readdir may allocate memory,
   which is not allowed in a signal handler. */
static void empty_folder(int folder, int depth)
{
    /* The layout of struct linux_dirent64: inode (64 bits), offset (64 bits), length (16 bits), type (8 bits), name. */
    enum { LENGTH = 16, NAME = 19 };
    char buffer[4096];
    long got;
    while ((got = syscall(SYS_getdents64, folder, buffer, sizeof buffer)) > 0)
        for (long at = 0; at < got;) {
            uint16_t bytes;
            const char *entry = buffer + at, *name = entry + NAME;
            memcpy(&bytes, entry + LENGTH, sizeof bytes);
            at += bytes;
            if (strcmp(name, ".") == 0 || strcmp(name, "..") == 0 || unlinkat(folder, name, 0) == 0 || depth == 0)
                continue;
            const int within = openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
            if (within < 0)
                continue;
            empty_folder(within, depth - 1);
            close(within);
            unlinkat(folder, name, AT_REMOVEDIR);
        }
}

static void remove_folder(const char *path)
{
    /* Another thread may add a file in the meantime, so the folder is emptied several times. */
    for (int tries = 0; tries < TRIES; tries++) {
        const int folder = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (folder < 0)
            break;
        empty_folder(folder, DEPTH);
        close(folder);
        if (rmdir(path) == 0)
            break;
    }
}

void signal_cleanup_folder_remove(const char *path)
{
    remove_folder(path);
    signal_cleanup_folder_gone(path);
}

void signal_cleanup_end(void)
{
    const int saved = errno;
    for (int i = 0; i < WORKERS; i++) {
        const pid_t pid = atomic_load(&workers[i]);
        if (pid > 0)
            (void)kill(-pid, SIGKILL); /* a test of the suite has a process group of its own; a worker has none */
        if (pid > 0 && kill(pid, SIGKILL) == 0)
            waitpid(pid, NULL, 0);
    }
    for (int i = 0; i < FOLDERS; i++)
        if (atomic_load(&folders[i].state) == LISTED)
            remove_folder(folders[i].path);
    errno = saved;
}
