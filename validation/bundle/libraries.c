/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/libraries.h"

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"

extern char **environ;

enum { PROGRAM_TEXT = 1 << 20, PATHS_MAX = 1024 };

ost_status libraries_digest(const char *path, char hex[OST_DIGEST_HEX], int64_t *size, ost_error *err)
{
    static unsigned char block[1 << 16];
    ost_hasher *hasher = NULL;
    ost_digest digest = {{0}};
    FILE *file;
    *size = 0;
    ost_status status = ost_file_stream(path, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_hasher_open(&hasher, err);
    for (size_t n; status == OST_OK && (n = fread(block, 1, sizeof block, file)) > 0; *size += (int64_t)n)
        status = ost_hasher_add(hasher, block, n, err);
    if (status == OST_OK && ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot be read", path);
    fclose(file);
    ost_status closed = ost_hasher_close(hasher, status == OST_OK ? &digest : NULL, NULL);
    ost_digest_hex(&digest, hex);
    return status != OST_OK ? status : closed;
}

/* -------------------------------------------------------------- the loader */

typedef struct visit {
    json_t *libraries, *needed;
} visit;

/* The id that the linker gave the file: a note of type 3 by "GNU". */
static void build_id(const struct dl_phdr_info *info, char hex[129])
{
    hex[0] = '\0';
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *p = &info->dlpi_phdr[i];
        if (p->p_type != PT_NOTE)
            continue;
        const unsigned char *at = (const unsigned char *)(info->dlpi_addr + p->p_vaddr);
        for (size_t left = p->p_memsz; left > 12;) {
            uint32_t head[3]; /* sizes of name and text, type */
            memcpy(head, at, sizeof head);
            const size_t name = (head[0] + 3u) & ~3u, text = (head[1] + 3u) & ~3u, all = 12 + name + text;
            if (head[0] > left || head[1] > left || all > left)
                break;
            if (head[2] == NT_GNU_BUILD_ID && head[0] == 4 && memcmp(at + 12, "GNU", 4) == 0 && head[1] <= 64) {
                for (uint32_t k = 0; k < head[1]; k++)
                    snprintf(hex + 2 * k, 3, "%02x", at[12 + name + k]);
                return;
            }
            at += all;
            left -= all;
        }
    }
}

/* The names that the program itself asks for. */
static void needed_by(const struct dl_phdr_info *info, json_t *names)
{
    for (int i = 0; i < info->dlpi_phnum; i++) {
        if (info->dlpi_phdr[i].p_type != PT_DYNAMIC)
            continue;
        const ElfW(Dyn) *dynamic = (const ElfW(Dyn) *)(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr);
        const char *strings = NULL;
        for (const ElfW(Dyn) *d = dynamic; d->d_tag != DT_NULL; d++)
            if (d->d_tag == DT_STRTAB) /* relocated by most loaders, not by all */
                strings = (const char *)(d->d_un.d_ptr < info->dlpi_addr ? info->dlpi_addr + d->d_un.d_ptr : d->d_un.d_ptr);
        for (const ElfW(Dyn) *d = dynamic; strings && d->d_tag != DT_NULL; d++)
            if (d->d_tag == DT_NEEDED)
                json_object_set_new(names, strings + d->d_un.d_val, json_true());
    }
}

static int visit_one(struct dl_phdr_info *info, size_t size, void *user)
{
    visit *v = user;
    char id[129];
    (void)size;
    if (!*info->dlpi_name)
        needed_by(info, v->needed);
    /* Kernels that PoCL compiled are loaded from its cache: made of our own sources, under names of the day. */
    if (*info->dlpi_name != '/' || strstr(info->dlpi_name, "/kcache/") || strncmp(info->dlpi_name, "/tmp/", 5) == 0)
        return 0;
    build_id(info, id);
    const char *name = strrchr(info->dlpi_name, '/') + 1;
    json_t *row = json_pack("{s:s,s:s,s:b,s:s}", "file", info->dlpi_name, "soname", name, "linked", json_object_get(v->needed, name) != NULL, "build_id", id);
    return row && json_array_append_new(v->libraries, row) == 0 ? 0 : 1;
}

/* ----------------------------------------------------------- the packages */

/* What a program says, cut at PROGRAM_TEXT; NULL when it cannot be asked. free() it. */
static char *said_by(char *const argv[])
{
    int ends[2];
    pid_t pid;
    posix_spawn_file_actions_t actions;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return NULL;
    char *text = malloc(PROGRAM_TEXT + 1);
    bool started = text && posix_spawn_file_actions_init(&actions) == 0;
    if (started) {
        started = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0) == 0 && posix_spawn_file_actions_adddup2(&actions, ends[1], 1) == 0 &&
                  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0) == 0 && posix_spawnp(&pid, argv[0], &actions, NULL, argv, environ) == 0;
        posix_spawn_file_actions_destroy(&actions);
    }
    close(ends[1]);
    size_t used = 0;
    char rest[4096];
    while (started) { /* reads on to its end, or it would wait for us */
        const ssize_t n = used < PROGRAM_TEXT ? read(ends[0], text + used, PROGRAM_TEXT - used) : read(ends[0], rest, sizeof rest);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        used += used < PROGRAM_TEXT ? (size_t)n : 0;
    }
    close(ends[0]);
    while (started && waitpid(pid, NULL, 0) < 0 && errno == EINTR)
        ;
    if (!started) {
        free(text);
        return NULL;
    }
    text[used] = '\0';
    return text;
}

/* Packages list a file where it was before folders were merged: with /usr or without. */
static void other_name(const char *path, char out[PATH_MAX])
{
    if (strncmp(path, "/usr/", 5) == 0)
        snprintf(out, PATH_MAX, "%s", path + 4);
    else
        snprintf(out, PATH_MAX, "/usr%s", path);
}

/* {path: package} of all names of all files, by one call. */
static json_t *owners(const json_t *libraries)
{
    const size_t count = json_array_size(libraries);
    char **argv = calloc(4 * count + 8, sizeof *argv);
    json_t *out = json_object();
    size_t n = 0;
    static char env[] = "env", locale[] = "LC_ALL=C", program[] = "dpkg-query", search[] = "--search";
    if (!argv)
        return out;
    argv[n++] = env, argv[n++] = locale, argv[n++] = program, argv[n++] = search;
    for (size_t i = 0; i < count && n < PATHS_MAX; i++) {
        const char *file = json_string_value(json_object_get(json_array_get(libraries, i), "file"));
        char real[PATH_MAX], other[PATH_MAX];
        if (!realpath(file, real))
            snprintf(real, sizeof real, "%s", file);
        const char *names[2] = {file, real};
        for (int k = 0; k < 2; k++) {
            other_name(names[k], other);
            argv[n++] = strdup(names[k]);
            argv[n++] = strdup(other);
        }
    }
    char *text = count ? said_by(argv) : NULL;
    for (char *line = text ? strtok(text, "\n") : NULL; line; line = strtok(NULL, "\n")) {
        char *path = strstr(line, ": /");
        if (!path || strncmp(line, "diversion", 9) == 0)
            continue;
        line[strcspn(line, ":,")] = '\0'; /* libc6:amd64, or the first of several */
        json_object_set_new(out, path + 2, json_string(line));
    }
    free(text);
    for (size_t i = 4; i < n; i++)
        free(argv[i]);
    free(argv);
    return out;
}

/* {package: [version, maintainer]} */
static json_t *versions(json_t *packages)
{
    const char *path;
    json_t *value, *out = json_object();
    char **argv = calloc(json_object_size(packages) + 8, sizeof *argv);
    static char env[] = "env", locale[] = "LC_ALL=C", program[] = "dpkg-query", show[] = "--show", format[] = "--showformat=${Package}\t${Version}\t${Maintainer}\n";
    size_t n = 0;
    if (!argv)
        return out;
    argv[n++] = env, argv[n++] = locale, argv[n++] = program, argv[n++] = show, argv[n++] = format;
    json_object_foreach(packages, path, value)
        argv[n++] = strdup(json_string_value(value));
    char *text = n > 5 ? said_by(argv) : NULL;
    for (char *line = text ? strtok(text, "\n") : NULL; line; line = strtok(NULL, "\n")) {
        char *version = strchr(line, '\t'), *maintainer = version ? strchr(version + 1, '\t') : NULL;
        if (!maintainer)
            continue;
        *version = *maintainer = '\0';
        json_object_set_new(out, line, json_pack("[s,s]", version + 1, maintainer + 1));
    }
    free(text);
    for (size_t i = 5; i < n; i++)
        free(argv[i]);
    free(argv);
    return out;
}

static void name_package(json_t *row, const json_t *owner, const json_t *version)
{
    const char *file = json_string_value(json_object_get(row, "file")), *package = NULL, *its = NULL, *maintainer = NULL;
    char real[PATH_MAX], other[PATH_MAX];
    if (!realpath(file, real))
        snprintf(real, sizeof real, "%s", file);
    const char *names[2] = {file, real};
    for (int k = 0; k < 2 && !package; k++) {
        other_name(names[k], other);
        package = json_string_value(json_object_get(owner, names[k]));
        if (!package)
            package = json_string_value(json_object_get(owner, other));
    }
    if (package)
        json_unpack(json_object_get(version, package), "[s,s]", &its, &maintainer);
    if (!its) { /* libz.so.1.2.13 says its version itself */
        its = strstr(real, ".so.");
        its = its ? its + 4 : "";
    }
    json_object_set_new(row, "package", json_string(package ? package : ""));
    json_object_set_new(row, "version", json_string(its));
    json_object_set_new(row, "maintainer", json_string(maintainer ? maintainer : ""));
}

static int by_file(const void *a, const void *b)
{
    return strcmp(json_string_value(json_object_get(*(json_t *const *)a, "file")), json_string_value(json_object_get(*(json_t *const *)b, "file")));
}

ost_status libraries_loaded(json_t **out, ost_error *err)
{
    visit v = {json_array(), json_object()};
    ost_status status = OST_OK;
    *out = NULL;
    dl_iterate_phdr(visit_one, &v);
    const size_t count = json_array_size(v.libraries);
    json_t **rows = calloc(count + 1, sizeof *rows);
    json_t *owner = owners(v.libraries), *version = versions(owner);
    if (!rows)
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for a list of libraries");
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        char hex[OST_DIGEST_HEX];
        int64_t size;
        rows[i] = json_array_get(v.libraries, i);
        status = libraries_digest(json_string_value(json_object_get(rows[i], "file")), hex, &size, err);
        json_object_set_new(rows[i], "sha256", json_string(hex));
        json_object_set_new(rows[i], "size", json_integer(size));
        name_package(rows[i], owner, version);
    }
    if (status == OST_OK) {
        qsort(rows, count, sizeof *rows, by_file);
        *out = json_array();
        for (size_t i = 0; i < count; i++)
            json_array_append(*out, rows[i]);
    }
    free(rows);
    json_decref(owner);
    json_decref(version);
    json_decref(v.libraries);
    json_decref(v.needed);
    return status;
}
