/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "validation/signal_cleanup.h"

static const char *base_folder(void)
{
    const char *base = getenv("TMPDIR");
    return base && *base ? base : "/tmp";
}

static ost_status refuse(const char *what, int n, ost_error *err)
{
    return ost_fail(err, OST_ERR_IO, "no %s for traces in '%.200s': %s", what, base_folder(),
                    n >= SCRATCH_PATH ? "the name is too long" : strerror(errno));
}

ost_status scratch_make(char path[SCRATCH_PATH], ost_error *err)
{
    const int n = snprintf(path, SCRATCH_PATH, "%s/osteon-validate-XXXXXX", base_folder());
    if (n >= SCRATCH_PATH || !mkdtemp(path)) {
        ost_status status = refuse("folder", n, err);
        path[0] = '\0';
        return status;
    }
    signal_cleanup_folder(path);
    return OST_OK;
}

void scratch_remove(const char *path)
{
    if (!*path)
        return;
    rmdir(path);
    signal_cleanup_folder_gone(path);
}

ost_status scratch_file(int *fd, ost_error *err)
{
    char path[SCRATCH_PATH];
    *fd = -1;
#ifdef O_TMPFILE
    *fd = open(base_folder(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
#endif
    if (*fd >= 0)
        return OST_OK;
    const int n = snprintf(path, sizeof path, "%s/osteon-validate-XXXXXX", base_folder());
    if (n < SCRATCH_PATH)
        *fd = mkostemp(path, O_CLOEXEC);
    if (*fd < 0)
        return refuse("file", n, err);
    unlink(path);
    return OST_OK;
}

void scratch_name(int fd, char name[SCRATCH_NAME])
{
    snprintf(name, SCRATCH_NAME, "/proc/self/fd/%d", fd);
}

ost_status scratch_check_space(uint64_t bytes, ost_error *err)
{
    struct statvfs space;
    if (statvfs(base_folder(), &space) != 0)
        return refuse("room", 0, err);
    const uint64_t left = (uint64_t)space.f_bavail * space.f_frsize;
    if (left >= bytes)
        return OST_OK;
    return ost_fail(err, OST_ERR_IO,
                    "'%.200s' has %llu MB left, and traces may need %llu MB at a time; TMPDIR names another folder, "
                    "fewer --jobs need less",
                    base_folder(), (unsigned long long)(left / 1000000), (unsigned long long)(bytes / 1000000));
}
