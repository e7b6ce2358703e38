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
#include "validation/bundle/copyright.h"

extern char **environ;

enum { PROGRAM_TEXT = 1 << 20, PATHS_MAX = 1024 };

ost_status libraries_digest(const char *path, char hex[OST_DIGEST_HEX], int64_t *size, ost_error *err)
{
    static unsigned char block[1 << 16];
    ost_hasher *hasher = NULL;
    ost_digest digest = {{0}};
    FILE *file;
    *size = 0;
    ost_status status = ost_file_stream(path, &file, NULL, err);
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
    bool incomplete; /* true if memory was exhausted; the list is then incomplete */
} visit;

/* Writes the build id that the linker stored in the file. It is in the note with type 3 and name "GNU". */
static void build_id(const struct dl_phdr_info *info, char hex[129])
{
    hex[0] = '\0';
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *p = &info->dlpi_phdr[i];
        if (p->p_type != PT_NOTE)
            continue;
        const unsigned char *at = (const unsigned char *)(info->dlpi_addr + p->p_vaddr);
        for (size_t left = p->p_memsz; left > 12;) {
            uint32_t head[3]; /* header of an ELF note: length of the name, length of the descriptor, type */
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

/* Collects the names of the libraries that the program itself needs (DT_NEEDED). */
static void needed_by(const struct dl_phdr_info *info, visit *v)
{
    for (int i = 0; i < info->dlpi_phnum; i++) {
        if (info->dlpi_phdr[i].p_type != PT_DYNAMIC)
            continue;
        const ElfW(Dyn) *dynamic = (const ElfW(Dyn) *)(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr);
        const char *strings = NULL;
        for (const ElfW(Dyn) *d = dynamic; d->d_tag != DT_NULL; d++)
            if (d->d_tag == DT_STRTAB) /* Some loaders do not relocate the pointer to the string table. */
                strings = (const char *)(d->d_un.d_ptr < info->dlpi_addr ? info->dlpi_addr + d->d_un.d_ptr
                                                                         : d->d_un.d_ptr);
        for (const ElfW(Dyn) *d = dynamic; strings && d->d_tag != DT_NULL; d++)
            if (d->d_tag == DT_NEEDED)
                v->incomplete |= json_object_set_new(v->needed, strings + d->d_un.d_val, json_true()) != 0;
    }
}

static int visit_one(struct dl_phdr_info *info, size_t size, void *user)
{
    visit *v = user;
    char id[129];
    (void)size;
    if (!*info->dlpi_name)
        needed_by(info, v);
    /* Kernels compiled by PoCL are loaded from its cache under varying names. They are omitted, because they are made
       from this project's sources. */
    if (*info->dlpi_name != '/' || strstr(info->dlpi_name, "/kcache/") || strncmp(info->dlpi_name, "/tmp/", 5) == 0)
        return 0;
    build_id(info, id);
    const char *name = strrchr(info->dlpi_name, '/') + 1;
    json_t *row = json_pack("{s:s,s:s,s:b,s:s}", "file", info->dlpi_name, "soname", name, "linked",
                            json_object_get(v->needed, name) != NULL, "build_id", id);
    return row && json_array_append_new(v->libraries, row) == 0 ? 0 : 1;
}

/* ----------------------------------------------------------- the packages */

/*
 * Runs a program and sets *text to at most PROGRAM_TEXT bytes of its output, or to NULL if it is not installed. The
 * caller frees *text. If the program cannot be started or fails, or if its output cannot be read, returns an error,
 * because the list of libraries would be incomplete.
 */
static ost_status output_of(char *const argv[], char **text, ost_error *err)
{
    enum { NOTHING_FOUND = 1, NOT_INSTALLED = 127 };
    int ends[2], state = 0, failed;
    pid_t pid = -1;
    posix_spawn_file_actions_t actions;
    *text = NULL;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return ost_fail(err, OST_ERR_IO, "no pipe for %s: %s", argv[2], strerror(errno));
    char *output = malloc(PROGRAM_TEXT + 1);
    failed = output ? posix_spawn_file_actions_init(&actions) : ENOMEM;
    if (!failed) {
        failed = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        failed = failed ? failed : posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
        failed = failed ? failed : posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
        failed = failed ? failed : posix_spawnp(&pid, argv[0], &actions, NULL, argv, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    close(ends[1]);
    const bool started = !failed;
    size_t used = 0;
    char discarded[4096];
    while (started) { /* the output is read to its end, because the program would block on a full pipe */
        const ssize_t n = used < PROGRAM_TEXT ? read(ends[0], output + used, PROGRAM_TEXT - used)
                                              : read(ends[0], discarded, sizeof discarded);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            failed = errno;
        if (n <= 0)
            break;
        used += used < PROGRAM_TEXT ? (size_t)n : 0;
    }
    close(ends[0]);
    while (started && waitpid(pid, &state, 0) < 0)
        if (errno != EINTR) {
            failed = errno;
            break;
        }
    ost_status status = failed ? ost_fail(err, failed == ENOMEM ? OST_ERR_MEMORY : OST_ERR_IO,
                                          "%s cannot be run for the list of software: %s", argv[2], strerror(failed))
                               : OST_OK;
    const int code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
    if (status == OST_OK && code > NOTHING_FOUND && code != NOT_INSTALLED)
        status = ost_fail(err, OST_ERR_IO, "%s failed (status %d), which lists the packages of libraries", argv[2],
                          code);
    if (status == OST_OK && code < 0)
        status = ost_fail(err, OST_ERR_IO, "%s was ended by a signal, which lists the packages of libraries", argv[2]);
    if (status != OST_OK || code == NOT_INSTALLED) {
        free(output);
        return status;
    }
    output[used] = '\0';
    *text = output;
    return OST_OK;
}

/* Writes the alternative path of a file. Removes the prefix /usr from the path or, if the path does not have this
   prefix, adds it. A package may list the path that the file had before /bin and /lib were merged into /usr. */
static void other_name(const char *path, char out[PATH_MAX])
{
    if (strncmp(path, "/usr/", 5) == 0)
        snprintf(out, PATH_MAX, "%s", path + 4);
    else
        snprintf(out, PATH_MAX, "/usr%s", path);
}

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of libraries");
}

static void free_words(char **argv, size_t from, size_t n)
{
    for (size_t i = from; argv && i < n; i++)
        free(argv[i]);
    free(argv);
}

/* Makes an object {path: package} for all paths of all libraries, with one call of dpkg-query. */
static ost_status owners(const json_t *libraries, json_t *out, ost_error *err)
{
    const size_t count = json_array_size(libraries);
    char **argv = calloc(4 * count + 8, sizeof *argv), *text = NULL;
    size_t n = 0;
    bool complete = argv != NULL;
    static char env[] = "env", locale[] = "LC_ALL=C", program[] = "dpkg-query", search[] = "--search";
    if (!argv)
        return no_memory(err);
    argv[n++] = env, argv[n++] = locale, argv[n++] = program, argv[n++] = search;
    for (size_t i = 0; i < count && n < PATHS_MAX && complete; i++) {
        const char *file = json_string_value(json_object_get(json_array_get(libraries, i), "file"));
        char real[PATH_MAX], other[PATH_MAX];
        if (!realpath(file, real))
            snprintf(real, sizeof real, "%s", file);
        const char *names[2] = {file, real};
        for (int k = 0; k < 2 && complete; k++) {
            other_name(names[k], other);
            complete = (argv[n++] = strdup(names[k])) && (argv[n++] = strdup(other));
        }
    }
    ost_status status = !complete ? no_memory(err) : count ? output_of(argv, &text, err) : OST_OK;
    for (char *line = text ? strtok(text, "\n") : NULL; line && status == OST_OK; line = strtok(NULL, "\n")) {
        char *path = strstr(line, ": /");
        if (!path || strncmp(line, "diversion", 9) == 0)
            continue;
        /* keeps only the name of the first package, without its architecture ("libc6:amd64") */
        line[strcspn(line, ":,")] = '\0';
        if (json_object_set_new(out, path + 2, json_string(line)) != 0)
            status = no_memory(err);
    }
    free(text);
    free_words(argv, 4, n);
    return status;
}

/* Makes a JSON object {package: [version, maintainer]} of all installed packages. */
static ost_status versions(json_t *packages, json_t *out, ost_error *err)
{
    const char *path;
    json_t *value;
    char **argv = calloc(json_object_size(packages) + 8, sizeof *argv), *text = NULL;
    static char env[] = "env", locale[] = "LC_ALL=C", program[] = "dpkg-query", show[] = "--show",
                format[] = "--showformat=${Package}\t${Version}\t${Maintainer}\n";
    size_t n = 0;
    bool complete = true;
    if (!argv)
        return no_memory(err);
    argv[n++] = env, argv[n++] = locale, argv[n++] = program, argv[n++] = show, argv[n++] = format;
    json_object_foreach(packages, path, value)
        complete = complete && (argv[n++] = strdup(json_string_value(value)));
    ost_status status = !complete ? no_memory(err) : n > 5 ? output_of(argv, &text, err) : OST_OK;
    for (char *line = text ? strtok(text, "\n") : NULL; line && status == OST_OK; line = strtok(NULL, "\n")) {
        char *version = strchr(line, '\t'), *maintainer = version ? strchr(version + 1, '\t') : NULL;
        if (!maintainer)
            continue;
        *version = *maintainer = '\0';
        if (json_object_set_new(out, line, json_pack("[s,s]", version + 1, maintainer + 1)) != 0)
            status = no_memory(err);
    }
    free(text);
    free_words(argv, 5, n);
    return status;
}

/* Sets package, version, licence and maintainer of a library. */
static ost_status name_package(json_t *row, const json_t *owner, const json_t *version, ost_error *err)
{
    const char *file = json_string_value(json_object_get(row, "file")), *package = NULL, *its = NULL,
               *maintainer = NULL;
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
    char licence[COPYRIGHT_LICENCE];
    const ost_status status = copyright_of(package ? package : "", licence, err);
    if (status != OST_OK)
        return status;
    if (!its) { /* Takes the version from the name of the file, such as libz.so.1.2.13. */
        its = strstr(real, ".so.");
        its = its ? its + 4 : "";
    }
    const bool complete = json_object_set_new(row, "package", json_string(package ? package : "")) == 0 &&
                          json_object_set_new(row, "version", json_string(its)) == 0 &&
                          json_object_set_new(row, "licence", json_string(licence)) == 0 &&
                          json_object_set_new(row, "maintainer", json_string(maintainer ? maintainer : "")) == 0;
    return complete ? OST_OK : no_memory(err);
}

static int by_file(const void *a, const void *b)
{
    return strcmp(json_string_value(json_object_get(*(json_t *const *)a, "file")),
                  json_string_value(json_object_get(*(json_t *const *)b, "file")));
}

ost_status libraries_loaded(json_t **out, ost_error *err)
{
    visit v = {json_array(), json_object(), false};
    ost_status status = OST_OK;
    *out = NULL;
    if (!v.libraries || !v.needed || dl_iterate_phdr(visit_one, &v) != 0 || v.incomplete)
        status = no_memory(err);
    const size_t count = json_array_size(v.libraries);
    json_t **rows = calloc(count + 1, sizeof *rows);
    json_t *owner = json_object(), *version = json_object();
    if (status == OST_OK && (!rows || !owner || !version))
        status = no_memory(err);
    if (status == OST_OK)
        status = owners(v.libraries, owner, err);
    if (status == OST_OK)
        status = versions(owner, version, err);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        char hex[OST_DIGEST_HEX];
        int64_t size;
        rows[i] = json_array_get(v.libraries, i);
        status = libraries_digest(json_string_value(json_object_get(rows[i], "file")), hex, &size, err);
        if (status == OST_OK &&
            (json_object_set_new(rows[i], "sha256", json_string(hex)) != 0 ||
             json_object_set_new(rows[i], "size", json_integer(size)) != 0))
            status = no_memory(err);
        if (status == OST_OK)
            status = name_package(rows[i], owner, version, err);
    }
    if (status == OST_OK) {
        qsort(rows, count, sizeof *rows, by_file);
        *out = json_array();
        for (size_t i = 0; i < count && status == OST_OK; i++)
            if (json_array_append(*out, rows[i]) != 0)
                status = no_memory(err);
        if (status != OST_OK) {
            json_decref(*out);
            *out = NULL;
        }
    }
    free(rows);
    json_decref(owner);
    json_decref(version);
    json_decref(v.libraries);
    json_decref(v.needed);
    return status;
}
