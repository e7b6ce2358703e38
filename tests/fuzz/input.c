/* SPDX-License-Identifier: Apache-2.0 */
/* Creates the scratch folder with the inputs for readers that take a path. */
#include "fuzz.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[512];

static void die(const char *what)
{
    perror(what);
    exit(99);
}

static void remove_folder(void)
{
    DIR *dir = opendir(folder);
    if (!dir)
        return;
    for (struct dirent *entry; (entry = readdir(dir));)
        unlinkat(dirfd(dir), entry->d_name, 0);
    closedir(dir);
    rmdir(folder);
}

const char *fuzz_folder(void)
{
    if (!folder[0]) {
        /* The folder is in memory if possible, because thousands of small files are written per second. */
        const char *base = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : getenv("TMPDIR");
        snprintf(folder, sizeof folder, "%s/osteon-fuzz-XXXXXX", base && *base ? base : "/tmp");
        if (!mkdtemp(folder))
            die(folder);
        atexit(remove_folder);
    }
    return folder;
}

const char *fuzz_file(const char *name, const uint8_t *data, size_t size)
{
    static char path[1024];
    snprintf(path, sizeof path, "%s/%s", fuzz_folder(), name);
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0)
        die(path);
    while (size > 0) {
        ssize_t n = write(fd, data, size);
        if (n <= 0)
            die(path);
        data += n;
        size -= (size_t)n;
    }
    close(fd);
    return path;
}
