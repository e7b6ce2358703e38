/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/dicom/protocol.h"

void ost_dicom_files_free(ost_dicom_files *files)
{
    for (size_t i = 0; i < files->count; i++)
        free(files->path[i]);
    free(files->path);
    *files = (ost_dicom_files){0};
}

static ost_status add(ost_dicom_files *files, const char *path, ost_error *err)
{
    if (files->count == OST_DICOM_FILES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: is file %d of the folder; at most %d are examined, so pass the folder "
                        "of the series", path, OST_DICOM_FILES_MAX + 1, OST_DICOM_FILES_MAX);
    if (files->count == files->capacity) {
        const size_t more = files->capacity ? 2 * files->capacity : 64;
        char **grown = realloc(files->path, more * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the names of %zu files", path, more);
        files->path = grown;
        files->capacity = more;
    }
    files->path[files->count] = strdup(path);
    if (!files->path[files->count])
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a file name", path);
    files->count++;
    return OST_OK;
}

static ost_status walk(ost_dicom_files *files, const char *path, int depth, ost_error *err);

/*
 * Adds a directory entry or, if the entry is a folder, the files in the folder. The type of the entry is read without
 * following symbolic links.
 */
static ost_status visit(ost_dicom_files *files, int folder, const char *path, const char *name, int depth,
                        ost_error *err)
{
    char full[OST_DICOM_PATH_MAX];
    struct stat info;
    const size_t length = strlen(path);
    const char *slash = length && path[length - 1] == '/' ? "" : "/";
    if (snprintf(full, sizeof full, "%s%s%s", path, slash, name) >= (int)sizeof full)
        return ost_fail(err, OST_ERR_IO, "%s%s%s: the name has more than %zu bytes", path, slash, name,
                        sizeof full - 1);
    if (fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", full, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return walk(files, full, depth + 1, err);
    return S_ISREG(info.st_mode) ? add(files, full, err) : OST_OK;
}

static ost_status walk(ost_dicom_files *files, const char *path, int depth, ost_error *err)
{
    if (depth > OST_DICOM_DEPTH_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: lies more than %d folders deep; pass the folder of the series", path,
                        OST_DICOM_DEPTH_MAX);
    const int fd = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC | (depth ? O_NOFOLLOW : 0));
    DIR *folder = fd >= 0 ? fdopendir(fd) : NULL;
    if (!folder) {
        const int error = errno;
        if (fd >= 0)
            close(fd);
        return ost_fail(err, OST_ERR_IO, "%s: cannot read the folder: %s", path, strerror(error));
    }
    ost_status status = OST_OK;
    for (errno = 0; status == OST_OK; errno = 0) {
        const struct dirent *entry = readdir(folder);
        if (!entry) {
            if (errno)
                status = ost_fail(err, OST_ERR_IO, "%s: cannot read the folder: %s", path, strerror(errno));
            break;
        }
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            status = visit(files, fd, path, entry->d_name, depth, err);
    }
    closedir(folder);
    return status;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

ost_status ost_dicom_files_find(const char *path, ost_dicom_files *out, ost_error *err)
{
    struct stat info;
    *out = (ost_dicom_files){0};
    if (stat(path, &info) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    ost_status status;
    if (S_ISDIR(info.st_mode)) {
        status = walk(out, path, 0, err);
    } else if (strcasecmp(name, "DICOMDIR") == 0) {
        char folder[OST_DICOM_PATH_MAX];
        snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
        status = walk(out, folder, 0, err);
    } else {
        status = add(out, path, err);
    }
    if (status != OST_OK)
        ost_dicom_files_free(out);
    /* qsort does not accept NULL, even for 0 elements */
    else if (out->count)
        qsort(out->path, out->count, sizeof *out->path, by_name);
    return status;
}
