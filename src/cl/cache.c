/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the keys of cache entries, verifies entries when they are read, and writes entries by renaming temporary
   files. */
#include "cl/cache.h"

#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"

typedef struct entry_head {
    char magic[8];
    uint64_t length;
    ost_digest key, checksum;
} entry_head;

_Static_assert(sizeof(entry_head) == 80, "no padding");

static const char magic[8] = {'O', 'S', 'T', 'C', 'L', 'B', '0', '1'};

/* Maximum size of an entry in bytes, far above the size of any program. Without this limit, a damaged length could
   cause a huge allocation. */
enum { ENTRY_MAX = 1 << 28 };

/* Finds the folder of the cache. Relative folders in environment variables are ignored, as the XDG base directory
   specification requires. */
static void find_folder(char *out, size_t size)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int n = 0;
    if (cache && cache[0] == '/')
        n = snprintf(out, size, "%s/osteon", cache);
    else if (home && home[0] == '/')
        n = snprintf(out, size, "%s/.cache/osteon", home);
    if (n <= 0 || (size_t)n >= size)
        out[0] = 0;
}

ost_status ost_cl_cache_key(ost_cl_cache *cache, const char *const *parts, size_t count, ost_error *err)
{
    ost_hasher *hasher;
    ost_status status = ost_hasher_open(&hasher, err);
    if (status != OST_OK)
        return status;
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const uint64_t length = strlen(parts[i]);
        status = ost_hasher_add(hasher, &length, sizeof length, err);
        if (status == OST_OK)
            status = ost_hasher_add(hasher, parts[i], length, err);
    }
    ost_status closed = ost_hasher_close(hasher, status == OST_OK ? &cache->key : NULL, err);
    status = status == OST_OK ? closed : status;
    if (status != OST_OK)
        return status;
    char hex[OST_DIGEST_HEX];
    find_folder(cache->folder, sizeof cache->folder);
    snprintf(cache->entry, sizeof cache->entry, "cl-%s.bin", ost_digest_hex(&cache->key, hex));
    return OST_OK;
}

/* Returns true if only the effective user can have written the file or folder fd. Permissions that an access
   control list grants appear in the group bits of the mode. */
static bool is_private(int fd)
{
    struct stat info;
    return fstat(fd, &info) == 0 && info.st_uid == geteuid() && (info.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/* Opens the folder of the cache. Returns -1 if the folder does not exist or is not private. */
static int open_folder(const ost_cl_cache *cache)
{
    const int folder = cache->folder[0] ? open(cache->folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1;
    if (folder >= 0 && !is_private(folder)) {
        close(folder);
        return -1;
    }
    return folder;
}

static bool believable(const ost_cl_cache *cache, const entry_head *head, const unsigned char *binary)
{
    ost_digest checksum;
    return memcmp(&head->key, &cache->key, sizeof cache->key) == 0 &&
           ost_digest_bytes(binary, head->length, &checksum, NULL) == OST_OK &&
           ost_digest_equal(&checksum, &head->checksum);
}

/*
 * Number of zero bytes that follow the binary in memory. PoCL 3.1 reads a complete header before it checks the binary's
 * length. If the binary is shorter than a header, PoCL also reads these bytes.
 */
enum { SLACK = 256 };

/* Reads an entry of file->size bytes and returns its binary. Returns NULL if the entry is not valid. */
static unsigned char *read_entry(const ost_cl_cache *cache, const ost_file *file, size_t *size)
{
    if (file->size <= (int64_t)sizeof(entry_head) || file->size > (int64_t)sizeof(entry_head) + ENTRY_MAX ||
        !is_private(file->fd))
        return NULL;
    entry_head head;
    const size_t length = (size_t)file->size - sizeof head;
    unsigned char *entry = calloc((size_t)file->size + SLACK, 1);
    if (entry && ost_file_fill(cache->entry, file, entry, NULL) == OST_OK) {
        memcpy(&head, entry, sizeof head);
        if (memcmp(head.magic, magic, sizeof magic) == 0 && head.length == length &&
            believable(cache, &head, entry + sizeof head)) {
            memmove(entry, entry + sizeof head, length);
            memset(entry + length, 0, SLACK);
            *size = length;
            return entry;
        }
    }
    free(entry);
    return NULL;
}

unsigned char *ost_cl_cache_load(const ost_cl_cache *cache, size_t *size)
{
    ost_file file;
    unsigned char *binary = NULL;
    *size = 0;
    const int folder = open_folder(cache);
    if (folder >= 0 && ost_file_open_within(folder, cache->entry, &file, NULL) == OST_OK) {
        binary = read_entry(cache, &file, size);
        close(file.fd);
    }
    if (folder >= 0)
        close(folder);
    return binary;
}

/* Writes an entry to a file with a temporary name in the folder, and then renames the file. */
static bool write_entry(const ost_cl_cache *cache, int folder, const entry_head *head, const unsigned char *binary)
{
    char fresh[sizeof cache->entry + 40];
    uint64_t random[2];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return false;
    snprintf(fresh, sizeof fresh, "%s.%016" PRIx64 "%016" PRIx64, cache->entry, random[0], random[1]);
    const int fd = openat(folder, fresh, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    FILE *f = fd >= 0 ? fdopen(fd, "wb") : NULL;
    bool complete = f && fwrite(head, sizeof *head, 1, f) == 1 && fwrite(binary, 1, head->length, f) == head->length;
    if (f)
        complete = fclose(f) == 0 && complete;
    else if (fd >= 0)
        close(fd);
    complete = complete && renameat(folder, fresh, folder, cache->entry) == 0;
    if (fd >= 0 && !complete)
        unlinkat(folder, fresh, 0);
    return complete;
}

bool ost_cl_cache_store(const ost_cl_cache *cache, const unsigned char *binary, size_t size)
{
    entry_head head = {.length = size, .key = cache->key};
    memcpy(head.magic, magic, sizeof magic);
    if (!cache->folder[0] || size == 0 || size > ENTRY_MAX ||
        ost_digest_bytes(binary, size, &head.checksum, NULL) != OST_OK)
        return false;

    char parent[sizeof cache->folder];
    snprintf(parent, sizeof parent, "%s", cache->folder);
    *strrchr(parent, '/') = 0;
    mkdir(parent, 0700); /* creates the folder and its parent; a missing grandparent is not created */
    mkdir(cache->folder, 0700);
    const int folder = open_folder(cache);
    if (folder < 0)
        return false;
    const bool complete = write_entry(cache, folder, &head, binary);
    close(folder);
    return complete;
}
