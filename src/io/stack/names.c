/* SPDX-License-Identifier: Apache-2.0 */
#include "io/stack/names.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <osteon/grid.h>

#include "core/file.h"
#include "io/stack/slice.h"

enum { DIGITS_MAX = 18 };

/* ------------------------------------------------------------------- listing */

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

bool ost_stack_is_pattern(const char *path)
{
    struct stat info;
    return strchr(last_part(path), '*') && stat(path, &info) != 0;
}

void ost_stack_names_free(ost_stack_names *names)
{
    for (size_t i = 0; i < names->count; i++)
        free(names->paths[i]);
    free(names->paths);
    *names = (ost_stack_names){0, NULL};
}

/* Appends the path FOLDER/NAME. folder_bytes is 0 for the current folder. */
static ost_status append(ost_stack_names *names, const char *folder, int folder_bytes, const char *name, ost_error *err)
{
    if (names->count == OST_DIM_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%.*s: more than %d files; a stack has at most so many slices",
                        folder_bytes, folder, OST_DIM_MAX);
    if ((names->count & (names->count - 1)) == 0) {
        char **paths = realloc(names->paths, (names->count ? 2 * names->count : 1) * sizeof *paths);
        if (paths)
            names->paths = paths;
        else
            return ost_fail(err, OST_ERR_MEMORY, "%.*s: out of memory for its list of files", folder_bytes, folder);
    }
    const size_t size = (size_t)folder_bytes + strlen(name) + 2;
    char *path = malloc(size);
    if (!path)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a file name", name);
    snprintf(path, size, "%.*s%s%s", folder_bytes, folder,
             folder_bytes && folder[folder_bytes - 1] != '/' ? "/" : "", name);
    names->paths[names->count++] = path;
    return OST_OK;
}

static bool is_regular(DIR *dir, const char *name)
{
    struct stat info;
    return fstatat(dirfd(dir), name, &info, 0) == 0 && S_ISREG(info.st_mode);
}

/*
 * Lists the regular files of a folder whose names match the pattern; NULL matches every name. Hidden files are
 * ignored.
 */
static ost_status list(const char *folder, int folder_bytes, const char *pattern, ost_stack_names *out, ost_error *err)
{
    char name[4096];
    if (folder_bytes >= (int)sizeof name)
        return ost_fail(err, OST_ERR_INPUT, "%.60s...: the name is too long", folder);
    snprintf(name, sizeof name, "%.*s", folder_bytes, folder_bytes ? folder : ".");
    DIR *dir = opendir(folder_bytes ? name : ".");
    if (!dir && strchr(name, '*'))
        return ost_fail(err, OST_ERR_INPUT, "%s: a '*' can stand only in the name of a file, not of a folder", name);
    if (!dir)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", folder_bytes ? name : ".", strerror(errno));
    ost_status status = OST_OK;
    errno = 0;
    for (struct dirent *entry; status == OST_OK && (entry = readdir(dir)); errno = 0)
        if (entry->d_name[0] != '.' && is_regular(dir, entry->d_name) &&
            (!pattern || fnmatch(pattern, entry->d_name, 0) == 0))
            status = append(out, folder, folder_bytes, entry->d_name, err);
    if (status == OST_OK && errno)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", name, strerror(errno));
    closedir(dir);
    return status;
}

static int by_text(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Lists the files that a path denotes, sorted by the bytes of their names. */
static ost_status list_path(const char *path, ost_stack_names *out, ost_error *err)
{
    struct stat info;
    *out = (ost_stack_names){0, NULL};
    ost_status status;
    if (ost_stack_is_pattern(path))
        status = list(path, (int)(last_part(path) - path), last_part(path), out, err);
    else if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        status = list(path, (int)strlen(path), NULL, out, err);
    else
        status = append(out, "", 0, path, err);
    /* qsort does not accept NULL, even for 0 elements */
    if (status == OST_OK && out->count)
        qsort(out->paths, out->count, sizeof *out->paths, by_text);
    if (status != OST_OK)
        ost_stack_names_free(out);
    return status;
}

/* ------------------------------------------------------------------ numbers */

static size_t digits(const char *text)
{
    size_t n = 0;
    while (isdigit((unsigned char)text[n]))
        n++;
    return n;
}

/* Compares two strings of digits by their numeric values, for any number of digits. */
static int compare_digits(const char *a, size_t a_count, const char *b, size_t b_count)
{
    for (; a_count && *a == '0'; a_count--)
        a++;
    for (; b_count && *b == '0'; b_count--)
        b++;
    if (a_count != b_count)
        return a_count < b_count ? -1 : 1;
    return strncmp(a, b, a_count);
}

typedef enum likeness { ALIKE, EQUAL_NUMBERS, TEXT_DIFFERS, NUMBERS_DIFFER } likeness;

/*
 * Compares the names of two files. Returns ALIKE if they differ in exactly one number, and sets *at to the position of
 * this number among the numbers of the name, counted from 0.
 */
static likeness compare(const char *a, const char *b, int *at)
{
    likeness found = EQUAL_NUMBERS;
    int number = 0;
    while (*a || *b) {
        const size_t n = digits(a), m = digits(b);
        if (!n != !m || (!n && *a != *b))
            return TEXT_DIFFERS;
        if (n) {
            if (compare_digits(a, n, b, m) != 0) {
                if (found == ALIKE)
                    return NUMBERS_DIFFER;
                found = ALIKE;
                *at = number;
            }
            number++;
        }
        a += n ? n : 1;
        b += n ? m : 1;
    }
    return found;
}

/* Returns the value of the number with the index `at` in a name. Returns -1 if it has more than DIGITS_MAX digits. */
static int64_t number_of(const char *name, int at)
{
    for (int number = 0; *name; name++) {
        size_t n = digits(name);
        if (!n)
            continue;
        if (number++ == at) {
            for (; n > 1 && *name == '0'; n--)
                name++;
            return n > DIGITS_MAX ? -1 : (int64_t)strtoll(name, NULL, 10);
        }
        name += n - 1;
    }
    return -1;
}

typedef struct numbered {
    int64_t number;
    char *path;
} numbered;

static int by_number(const void *a, const void *b)
{
    const int64_t x = ((const numbered *)a)->number, y = ((const numbered *)b)->number;
    return (x > y) - (x < y);
}

static ost_status same_number(const char *path, const char *a, const char *b, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %s and %s have the same number; expected one file for each slice", path, a,
                    b);
}

static ost_status check_names(const char *path, const ost_stack_names *names, int *at, ost_error *err)
{
    int first = -1;
    for (size_t i = 1; i < names->count; i++) {
        const char *a = last_part(names->paths[0]), *b = last_part(names->paths[i]);
        int own = -1;
        switch (compare(a, b, &own)) {
        case ALIKE:
            if (first < 0)
                first = own;
            if (own == first)
                break;
            return ost_fail(err, OST_ERR_INPUT, "%s: %s and %s differ in another number than the other names; expected "
                            "names that differ only in the number of the slice", path, a, b);
        case EQUAL_NUMBERS:
            return same_number(path, a, b, err);
        case NUMBERS_DIFFER:
            return ost_fail(err, OST_ERR_INPUT, "%s: %s and %s differ in two numbers; expected names that differ only "
                            "in the number of the slice", path, a, b);
        case TEXT_DIFFERS:
            return ost_fail(err, OST_ERR_INPUT, "%s: %s is not named like %s; expected names that differ only in the "
                            "number of the slice; a pattern such as '%s/a*.tif' selects files", path, b, a, path);
        }
    }
    *at = first;
    return OST_OK;
}

static ost_status order(const char *path, ost_stack_names *names, ost_error *err)
{
    int at = -1;
    ost_status status = check_names(path, names, &at, err);
    if (status != OST_OK || names->count < 2)
        return status;
    numbered *all = malloc(names->count * sizeof *all);
    if (!all)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the numbers of %zu slices", path, names->count);
    for (size_t i = 0; i < names->count; i++) {
        all[i] = (numbered){number_of(last_part(names->paths[i]), at), names->paths[i]};
        if (all[i].number < 0)
            status = ost_fail(err, OST_ERR_INPUT, "%s: expected at most %d digits in the number of a slice",
                              names->paths[i], DIGITS_MAX);
    }
    qsort(all, names->count, sizeof *all, by_number);
    for (size_t i = 0; i < names->count; i++)
        names->paths[i] = all[i].path;
    for (size_t i = 1; i < names->count && status == OST_OK; i++) {
        const int64_t gap = all[i].number - all[i - 1].number;
        if (gap == 0)
            status = same_number(path, last_part(all[i - 1].path), last_part(all[i].path), err);
        else if (gap > 1)
            status = ost_fail(err, OST_ERR_INPUT, "%s: slice %lld is missing: %s follows %s", path,
                              (long long)all[i - 1].number + 1, last_part(all[i].path), last_part(all[i - 1].path));
    }
    free(all);
    return status;
}

ost_status ost_stack_names_read(const char *path, ost_stack_names *out, ost_error *err)
{
    ost_status status = list_path(path, out, err);
    if (status == OST_OK && out->count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: no file matches; expected the slices of a stack, TIFF or PNG", path);
    if (status == OST_OK)
        status = order(path, out, err);
    if (status != OST_OK)
        ost_stack_names_free(out);
    return status;
}

/* ---------------------------------------------------------------- detection */

ost_status ost_stack_find(const char *path, bool *is, ost_error *err)
{
    ost_stack_names names;
    *is = ost_stack_is_pattern(path);
    if (*is)
        return OST_OK;
    ost_status status = list_path(path, &names, err);
    *is = status == OST_OK && names.count > 0;
    for (size_t i = 0; i < names.count && status == OST_OK && *is; i++) {
        ost_slice_kind kind;
        status = ost_slice_sniff_file(names.paths[i], &kind, err);
        *is = kind != OST_SLICE_NONE;
    }
    ost_stack_names_free(&names);
    return status;
}
