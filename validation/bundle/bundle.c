/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/bundle.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "io/outfile.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"
#include "validation/bundle/manifest.h"
#include "validation/signal_cleanup.h"

enum { LOG_LINE = 1024 };

struct bundle {
    char out[BUNDLE_PATH], folder[BUNDLE_PATH];
    ost_digest last; /* digest of the last line of the log audit.log */
    /* time of the log's last line; the next line never gets an earlier time, even if the clock is set back */
    time_t last_time;
    /* descriptor of the unfinished folder, which this process locks while it writes files there; -1 if the folder
       could not be opened */
    int lock;
};

static void remove_folder(const char *folder);

/*
 * Removes unfinished folders OUT.part-XXXXXX of processes that have ended. A folder is removed if it
 * belongs to this user, has six characters after the dash, and is not locked by a running process.
 */
static void remove_stale(const char *out)
{
    enum { RANDOM = 6 };
    char parent[BUNDLE_PATH], path[BUNDLE_PATH + 256];
    const char *slash = strrchr(out, '/'), *base = slash ? slash + 1 : out;
    const size_t length = strlen(base);
    snprintf(parent, sizeof parent, "%.*s", slash ? (int)(slash - out) + 1 : 1, slash ? out : ".");
    DIR *dir = opendir(parent);
    for (struct dirent *e; dir && (e = readdir(dir));) {
        struct stat info;
        if (strncmp(e->d_name, base, length) != 0 || strncmp(e->d_name + length, ".part-", 6) != 0 ||
            strlen(e->d_name + length + 6) != RANDOM)
            continue;
        snprintf(path, sizeof path, "%s/%s", parent, e->d_name);
        const int fd = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (fd < 0)
            continue;
        if (fstat(fd, &info) == 0 && info.st_uid == geteuid() && flock(fd, LOCK_EX | LOCK_NB) == 0)
            remove_folder(path);
        close(fd);
    }
    if (dir)
        closedir(dir);
}

ost_status bundle_begin(const char *out, bundle **b, ost_error *err)
{
    *b = NULL;
    struct stat info;
    if (lstat(out, &info) == 0)
        return ost_fail(err, OST_ERR_IO, "%s: already exists; choose a new folder for the bundle", out);
    bundle *made = calloc(1, sizeof *made);
    if (!made)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bundle");
    size_t length = strlen(out);
    while (length > 1 && out[length - 1] == '/')
        length--;
    const int n = snprintf(made->out, sizeof made->out, "%.*s", (int)length, out);
    const int m = snprintf(made->folder, sizeof made->folder, "%.*s.part-XXXXXX", (int)length, out);
    if (n < 1 || m >= (int)sizeof made->folder - 64) {
        free(made);
        return ost_fail(err, OST_ERR_USAGE, "'%.60s': no name for a bundle", out);
    }
    remove_stale(made->out);
    if (!mkdtemp(made->folder)) {
        ost_status status = ost_fail(err, OST_ERR_IO, "%s: cannot make the folder: %s", out, strerror(errno));
        free(made);
        return status;
    }
    signal_cleanup_folder(made->folder);
    made->lock = open(made->folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (made->lock >= 0)
        (void)flock(made->lock, LOCK_EX | LOCK_NB);
    /* mkdtemp makes a folder with mode 0700; the second chmod sets the mode that mkdir would set */
    chmod(made->folder, 0755);
    const mode_t mask = umask(0);
    umask(mask);
    chmod(made->folder, 0777 & ~mask);
    *b = made;
    return OST_OK;
}

const char *bundle_folder(const bundle *b)
{
    return b->folder;
}

/* Writes the path of file `name` in the bundle. If the name contains a folder, creates this folder. */
static ost_status path_of(const bundle *b, const char *name, char path[BUNDLE_PATH], ost_error *err)
{
    const int n = snprintf(path, BUNDLE_PATH, "%s/%s", b->folder, name);
    if (n >= BUNDLE_PATH)
        return ost_fail(err, OST_ERR_USAGE, "%s: too long", name);
    char *slash = strchr(path + strlen(b->folder) + 1, '/');
    if (slash) {
        *slash = '\0';
        if (mkdir(path, 0777) != 0 && errno != EEXIST)
            return ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
        *slash = '/';
    }
    return OST_OK;
}

ost_status bundle_put(bundle *b, const char *name, const void *bytes, size_t size, ost_error *err)
{
    char path[BUNDLE_PATH];
    ost_outfile *file;
    folder_about about;
    if (!folder_describe(name, &about))
        return ost_fail(err, OST_ERR_INTERNAL,
                        "%s: no bundle has a file of this name; the table in validation/bundle/folder.c lists them",
                        name);
    ost_status status = path_of(b, name, path, err);
    if (status == OST_OK)
        status = ost_outfile_open(path, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_write(file, bytes, size, err);
    if (status == OST_OK)
        return ost_outfile_commit(file, err);
    ost_outfile_discard(file);
    return status;
}

ost_status bundle_put_json(bundle *b, const char *name, const json_t *value, ost_error *err)
{
    char *text = json_dumps(value, JSON_SORT_KEYS | JSON_INDENT(1));
    if (!text)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    const size_t size = strlen(text);
    text[size] = '\n'; /* The terminating NUL is replaced by a newline. */
    ost_status status = bundle_put(b, name, text, size + 1, err);
    free(text);
    return status;
}

ost_status bundle_log(bundle *b, const char *action, ost_error *err, const char *detail, ...)
{
    char line[LOG_LINE], text[LOG_LINE - 256], hex[OST_DIGEST_HEX], path[BUNDLE_PATH];
    struct tm utc;
    const time_t clock = time(NULL), now = clock > b->last_time ? clock : b->last_time;
    va_list args;
    va_start(args, detail);
    vsnprintf(text, sizeof text, detail, args);
    va_end(args);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    b->last_time = now;
    gmtime_r(&now, &utc);
    const int n = snprintf(line, sizeof line, "%s\t%04d-%02d-%02dT%02d:%02d:%02dZ\t%s\t%s\n",
                           ost_digest_hex(&b->last, hex), utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                           utc.tm_min, utc.tm_sec, action, text);
    ost_status status = path_of(b, BUNDLE_LOG, path, err);
    FILE *file = status == OST_OK ? fopen(path, "ab") : NULL;
    if (!file)
        return status != OST_OK ? status : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    const bool written = fwrite(line, 1, (size_t)n, file) == (size_t)n;
    if (fclose(file) != 0 || !written)
        return ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    return ost_digest_bytes(line, (size_t)n, &b->last, err);
}

static ost_status sync_folder(const char *path, ost_error *err)
{
    const int fd = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0 || fsync(fd) != 0) {
        ost_status status = ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
        if (fd >= 0)
            close(fd);
        return status;
    }
    close(fd);
    return OST_OK;
}

ost_status bundle_end(bundle *b, ost_error *err)
{
    json_t *manifest = NULL;
    ost_status status = manifest_of(b->folder, &manifest, err);
    char *text = status == OST_OK ? manifest_text(manifest) : NULL;
    if (status == OST_OK && !text)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a manifest");
    if (status == OST_OK)
        status = bundle_put(b, MANIFEST_FILE, text, strlen(text), err);
    if (status == OST_OK)
        status = sync_folder(b->folder, err);
    /* Another process may have created a folder with the bundle's name in the meantime. If that folder is not
       empty, rename fails. */
    if (status == OST_OK && rename(b->folder, b->out) != 0)
        status = ost_fail(err, OST_ERR_IO, "%s: %s", b->out, strerror(errno));
    free(text);
    json_decref(manifest);
    if (status == OST_OK) {
        signal_cleanup_folder_gone(b->folder);
        if (b->lock >= 0)
            close(b->lock);
        free(b);
    } else
        bundle_abandon(b);
    return status;
}

/* Removes the folder of an incomplete bundle with all files and folders in it. */
static void remove_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir)
        return;
    for (struct dirent *e; (e = readdir(dir));) {
        char path[BUNDLE_PATH + 256];
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (unlink(path) != 0 && (errno == EISDIR || errno == EPERM))
            remove_folder(path);
    }
    closedir(dir);
    rmdir(folder);
}

void bundle_abandon(bundle *b)
{
    if (!b)
        return;
    remove_folder(b->folder);
    signal_cleanup_folder_gone(b->folder);
    if (b->lock >= 0)
        close(b->lock);
    free(b);
}

/* ------------------------------------------------------- checking a bundle */

static ost_status check_log(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err)
{
    char *bytes, hex[OST_DIGEST_HEX], text[128];
    size_t size;
    ost_digest last = {{0}};
    ost_status status = bundle_find(folder, BUNDLE_LOG, &bytes, &size, err);
    if (status != OST_OK)
        return status;
    if (!bytes) {
        problem(user, BUNDLE_ABSENT, BUNDLE_LOG, "is missing");
        ++*found;
        return OST_OK;
    }
    int number = 1;
    for (const char *at = bytes, *end = bytes + size; at < end && status == OST_OK; number++) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        ost_digest_hex(&last, hex);
        if (!stop || stop - at < OST_DIGEST_HEX || memcmp(at, hex, OST_DIGEST_HEX - 1) != 0 ||
            at[OST_DIGEST_HEX - 1] != '\t') {
            snprintf(text, sizeof text,
                     stop ? "line %d does not follow from the line before it" : "line %d is cut off", number);
            problem(user, BUNDLE_DIFFERENT, BUNDLE_LOG, text);
            ++*found;
            break;
        }
        status = ost_digest_bytes(at, (size_t)(stop + 1 - at), &last, err);
        at = stop + 1;
    }
    free(bytes);
    return status;
}

ost_status bundle_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err)
{
    ost_status status = manifest_check(folder, problem, user, found, err);
    if (status == OST_OK)
        status = check_log(folder, problem, user, found, err);
    return status;
}
