/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "validation/bundle/limits.h"

enum { FILES_MAX = 100000, BLOCK = 1 << 16 };
#define MB ((int64_t)1 << 20)

/* The files that a bundle may contain, with the rules for each. */
static const struct {
    const char *name;
    folder_about about;
} table[] = {
    {"README.md", {false, false, 4 * MB}},
    {"anomalies.csv", {false, false, 64 * MB}},
    {"audit.log", {true, false, 16 * MB}},
    {"case.json", {false, false, 64 * MB}},
    {"cases.jsonl", {false, true, 512 * MB}},
    {"common.json", {false, true, 16 * MB}},
    {"deviations.csv", {false, false, 4 * MB}},
    {"devices.json", {true, true, 16 * MB}},
    {"environment.json", {true, true, 64 * MB}},
    {"impact.json", {true, true, 64 * MB}},
    {"inputs.csv", {false, false, 16 * MB}},
    {"junit.xml", {true, false, 64 * MB}},
    {"known-anomalies.csv", {false, true, 4 * MB}},
    {"manifest.json", {true, false, 64 * MB}},
    {"margins.csv", {false, false, 256 * MB}},
    {"protocol.json", {false, false, 16 * MB}},
    {"report.html", {true, false, 256 * MB}},
    {"requirements.csv", {false, true, 4 * MB}},
    {"results.json", {false, false, 64 * MB}},
    {"results.tap", {false, false, 64 * MB}},
    {"sbom.spdx.json", {true, true, 64 * MB}},
    {"sensitivity.json", {false, true, 16 * MB}},
    {"soup.csv", {true, true, 16 * MB}},
    {"suite.json", {true, true, 16 * MB}},
    {"times.json", {true, true, 64 * MB}},
    {"tools.json", {true, true, 64 * MB}},
    {"trace.csv", {true, false, 16 * MB}},
};

static const char *const folders[] = {"pictures", "cases"};

/* Returns true if the name of a file in a subfolder is allowed. In pictures/ and cases/ a name consists of lower-case
   letters, digits and dashes, followed by `ending`. In signatures/, any plain name is allowed, and `ending` is NULL. */
static bool within(const char *name, const char *folder, const char *ending)
{
    const size_t head = strlen(folder);
    if (strncmp(name, folder, head) != 0 || name[head] != '/')
        return false;
    const char *base = name + head + 1;
    if (!ending)
        return *base != '.' && *base != '\0' &&
               base[strspn(base, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-")] == '\0';
    const size_t plain = strspn(base, "abcdefghijklmnopqrstuvwxyz0123456789-");
    return plain > 0 && strcmp(base + plain, ending) == 0;
}

const char *folder_name(size_t row)
{
    return row < sizeof table / sizeof table[0] ? table[row].name : NULL;
}

bool folder_describe(const char *name, folder_about *out)
{
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        if (strcmp(table[i].name, name) == 0) {
            *out = table[i].about;
            return true;
        }
    const bool picture = within(name, "pictures", ".png"), one = within(name, "cases", ".json"),
               signature = within(name, "signatures", NULL);
    *out = (folder_about){signature, false, picture ? 64 * MB : one ? 16 * MB : MB};
    return picture || one || signature;
}

/* ----------------------------------------------------------- opening files */

static ost_status open_folder(int above, const char *name, const char *path, bool follow, int *fd, bool *absent,
                              ost_error *err)
{
    *fd = openat(above, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NONBLOCK | (follow ? 0 : O_NOFOLLOW));
    *absent = *fd < 0 && (errno == ENOENT || errno == ENOTDIR);
    return *fd >= 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
}

ost_status folder_open(const char *folder, const char *name, ost_file *out, ost_error *err)
{
    char inside[BUNDLE_PATH], text[BUNDLE_PATH];
    const char *slash = strchr(name, '/');
    folder_about about;
    int top, fd;
    ost_error why = {0};
    *out = (ost_file){.fd = -1};
    ost_status status = open_folder(AT_FDCWD, folder, folder, true, &top, &out->absent, err);
    if (status != OST_OK)
        return status;
    fd = top;
    if (slash) {
        snprintf(inside, sizeof inside, "%.*s", (int)(slash - name), name);
        status = open_folder(top, inside, inside, false, &fd, &out->absent, err);
    }
    if (status == OST_OK && ost_file_open_within(fd, slash ? slash + 1 : name, out, &why) != OST_OK)
        status = ost_fail(err, why.status, "%s/%s", folder, why.text);
    if (slash && fd >= 0)
        close(fd);
    close(top);
    if (status == OST_OK && folder_describe(name, &about) && out->size > about.most) {
        close(out->fd);
        out->fd = -1;
        return ost_fail(err, OST_ERR_RANGE, "%s/%s: has %lld bytes; at most %lld are expected", folder,
                        limits_printable(name, text, sizeof text), (long long)out->size, (long long)about.most);
    }
    return status;
}

/* Reads at most one block. *n is the number of bytes, 0 at the end of the file. */
static ost_status read_block(const char *name, int fd, void *to, size_t size, size_t *n, ost_error *err)
{
    ssize_t got;
    do
        got = read(fd, to, size);
    while (got < 0 && errno == EINTR);
    *n = got > 0 ? (size_t)got : 0;
    return got >= 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", name, strerror(errno));
}

ost_status folder_digest(const char *folder, const char *name, ost_digest *out, int64_t *size, ost_error *err)
{
    unsigned char block[BLOCK];
    ost_file file;
    ost_hasher *hasher = NULL;
    size_t n;
    *size = 0;
    *out = (ost_digest){{0}};
    ost_status status = folder_open(folder, name, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_hasher_open(&hasher, err);
    while (status == OST_OK && (status = read_block(name, file.fd, block, sizeof block, &n, err)) == OST_OK && n > 0) {
        status = ost_hasher_add(hasher, block, n, err);
        *size += (int64_t)n;
        if (status == OST_OK && *size > file.size)
            status = ost_fail(err, OST_ERR_IO, "%s/%s: its size changed while it was read", folder, name);
    }
    close(file.fd);
    const ost_status closed = ost_hasher_close(hasher, status == OST_OK ? out : NULL, status == OST_OK ? err : NULL);
    return status != OST_OK ? status : closed;
}

ost_status folder_compare(const char *folder, const char *name, const void *bytes, size_t size, bool *absent,
                          bool *same, ost_error *err)
{
    unsigned char block[BLOCK];
    ost_file file;
    ost_error why = {0};
    size_t done = 0, n;
    *same = false;
    ost_status status = folder_open(folder, name, &file, &why);
    *absent = file.absent;
    if (status != OST_OK)
        return file.absent ? OST_OK : ost_fail(err, status, "%s", why.text);
    *same = file.size >= 0 && (uint64_t)file.size == size;
    while (*same && (status = read_block(name, file.fd, block, sizeof block, &n, err)) == OST_OK && n > 0) {
        *same = n <= size - done && memcmp(block, (const unsigned char *)bytes + done, n) == 0;
        done += n;
    }
    *same = *same && done == size;
    close(file.fd);
    return status;
}

/* ----------------------------------------------------------- listing files */

typedef struct listing {
    folder_files *out;
    size_t capacity;
    bundle_problem *problem;
    void *user;
    int *found;
} listing;

static void report(listing *l, const char *name, const char *text)
{
    char plain[256];
    l->problem(l->user, BUNDLE_DIFFERENT, limits_printable(name, plain, sizeof plain), text);
    ++*l->found;
}

static ost_status add_file(listing *l, const char *name, int64_t size, ost_error *err)
{
    folder_files *o = l->out;
    if (o->count == FILES_MAX)
        return ost_fail(err, OST_ERR_INPUT, "more than %d files: no bundle", FILES_MAX);
    if (o->count == l->capacity) {
        l->capacity = l->capacity ? 2 * l->capacity : 64;
        folder_file *grown = realloc(o->files, l->capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu names", l->capacity);
        o->files = grown;
    }
    o->files[o->count] = (folder_file){strdup(name), size};
    return o->files[o->count++].name ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a name");
}

static const char *type_of(mode_t mode)
{
    return S_ISLNK(mode)    ? "is a symbolic link; a bundle has only regular files"
           : S_ISFIFO(mode) ? "is a pipe; a bundle has only regular files"
           : S_ISDIR(mode)  ? "is a folder that does not belong to a bundle"
                            : "is a device or a socket; a bundle has only regular files";
}

static bool known_folder(const char *name)
{
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++)
        if (strcmp(name, folders[i]) == 0)
            return true;
    return false;
}

static ost_status list_one(listing *l, int fd, const char *name, const char *base, ost_error *err)
{
    struct stat info;
    folder_about about;
    char text[160];
    if (fstatat(fd, base, &info, AT_SYMLINK_NOFOLLOW) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: %s", name, strerror(errno));
    if (!S_ISREG(info.st_mode))
        report(l, name, type_of(info.st_mode));
    else if (!folder_describe(name, &about))
        report(l, name, "does not belong to a bundle");
    else if (info.st_size > about.most) {
        snprintf(text, sizeof text, "has %lld bytes; at most %lld are expected", (long long)info.st_size,
                 (long long)about.most);
        report(l, name, text);
    } else
        return add_file(l, name, info.st_size, err);
    return OST_OK;
}

/* Lists one folder. `inside` is the name of a folder within the bundle, or "" for the bundle itself. */
static ost_status list_folder(listing *l, int top, const char *folder, const char *inside, ost_error *err)
{
    int fd = dup(top);
    bool absent;
    ost_status status = fd >= 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: %s", folder, strerror(errno));
    if (*inside && fd >= 0) {
        close(fd);
        status = open_folder(top, inside, inside, false, &fd, &absent, err);
    }
    DIR *dir = status == OST_OK ? fdopendir(fd) : NULL;
    if (!dir) {
        if (status == OST_OK) {
            status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", folder, strerror(errno));
            close(fd);
        }
        return status;
    }
    for (struct dirent *e; (status = bundle_next_entry(dir, folder, &e, err)) == OST_OK && e;) {
        char name[BUNDLE_PATH];
        struct stat info;
        snprintf(name, sizeof name, "%s%s%.255s", inside, *inside ? "/" : "", e->d_name);
        if (!*inside && strcmp(name, "signatures") == 0)
            continue; /* The folder signatures/ is skipped, because sign_check reads it. */
        if (!*inside && known_folder(name) && fstatat(dirfd(dir), e->d_name, &info, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISDIR(info.st_mode))
            status = list_folder(l, top, folder, name, err);
        else
            status = list_one(l, dirfd(dir), name, e->d_name, err);
        if (status != OST_OK)
            break;
    }
    closedir(dir);
    return status;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const folder_file *)a)->name, ((const folder_file *)b)->name);
}

ost_status folder_list(const char *folder, folder_files *out, bundle_problem *problem, void *user, int *found,
                       ost_error *err)
{
    listing l = {.out = out, .problem = problem, .user = user, .found = found};
    int top;
    bool absent;
    *out = (folder_files){0};
    ost_status status = open_folder(AT_FDCWD, folder, folder, true, &top, &absent, err);
    if (status != OST_OK)
        return status;
    status = list_folder(&l, top, folder, "", err);
    close(top);
    if (status == OST_OK && out->count) /* qsort requires a pointer that is not NULL, even for 0 elements. */
        qsort(out->files, out->count, sizeof *out->files, by_name);
    if (status != OST_OK)
        folder_free(out);
    return status;
}

void folder_free(folder_files *l)
{
    for (size_t i = 0; i < l->count; i++)
        free(l->files[i].name);
    free(l->files);
    *l = (folder_files){0};
}

ost_status bundle_next_entry(DIR *dir, const char *folder, struct dirent **entry, ost_error *err)
{
    do {
        errno = 0;
        *entry = readdir(dir);
    } while (*entry && (strcmp((*entry)->d_name, ".") == 0 || strcmp((*entry)->d_name, "..") == 0));
    return *entry || !errno ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", folder, strerror(errno));
}
