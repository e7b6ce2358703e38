/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A scratch folder for tests that read and write files. The folder is removed together with its
 * files. Include this file after harness.h.
 */
#ifndef OST_TESTS_IO_SCRATCH_H
#define OST_TESTS_IO_SCRATCH_H

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* Creates a folder under TMPDIR and returns its path, which scratch_remove frees. */
static inline char *scratch_folder(void)
{
    const char *base = getenv("TMPDIR");
    char *folder = malloc(4096);
    assert_non_null(folder);
    snprintf(folder, 4096, "%s/osteon-test-XXXXXX", base && *base ? base : "/tmp");
    assert_non_null(mkdtemp(folder));
    return folder;
}

/* Returns the number of files in the folder, including hidden ones. */
static inline int scratch_count(const char *folder)
{
    int count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return count;
}

static inline void scratch_remove(char *folder)
{
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            assert_int_equal(unlinkat(dirfd(dir), entry->d_name, 0), 0);
    closedir(dir);
    assert_int_equal(rmdir(folder), 0);
    free(folder);
}

/* Returns the content of the file with a terminating NUL; the caller frees it. */
static inline char *scratch_read(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long end = ftell(file);
    assert_true(end >= 0);
    rewind(file);
    char *content = malloc((size_t)end + 1);
    assert_non_null(content);
    assert_int_equal(fread(content, 1, (size_t)end, file), (size_t)end);
    content[end] = 0;
    fclose(file);
    if (size)
        *size = (size_t)end;
    return content;
}

/*
 * Writes a file with these bytes to folder/name. The returned path is in a static buffer and
 * valid until the next call.
 */
static inline const char *scratch_write(const char *folder, const char *name, const void *bytes, size_t size)
{
    static char path[4096 + 64];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return path;
}

#endif
