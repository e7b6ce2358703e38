/* SPDX-License-Identifier: Apache-2.0 */
/* Entries of the cache: keys, reading with every doubt, writing by rename. */
#include "cl/cache.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct entry_head {
    char magic[8];
    uint64_t length;
    ost_digest key, checksum;
} entry_head;

_Static_assert(sizeof(entry_head) == 80, "no padding");

static const char magic[8] = {'O', 'S', 'T', 'C', 'L', 'B', '0', '1'};

/* More than any driver's program; keeps a damaged length from asking for memory. */
enum { ENTRY_MAX = 1 << 28 };

/* As the XDG base directory specification has it: relative folders do not count. */
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
    snprintf(cache->path, sizeof cache->path, "%s/cl-%s.bin", cache->folder, ost_digest_hex(&cache->key, hex));
    return OST_OK;
}

static bool believable(const ost_cl_cache *cache, const entry_head *head, const unsigned char *binary)
{
    ost_digest checksum;
    return memcmp(&head->key, &cache->key, sizeof cache->key) == 0 &&
           ost_digest_bytes(binary, head->length, &checksum, NULL) == OST_OK && ost_digest_equal(&checksum, &head->checksum);
}

/* Zeros behind the binary: PoCL (3.1) reads all of its head, and then how long it was. */
enum { SLACK = 256 };

unsigned char *ost_cl_cache_load(const ost_cl_cache *cache, size_t *size)
{
    *size = 0;
    FILE *f = cache->folder[0] ? fopen(cache->path, "rb") : NULL;
    if (!f)
        return NULL;
    entry_head head;
    unsigned char *binary = NULL;
    if (fread(&head, sizeof head, 1, f) == 1 && memcmp(head.magic, magic, sizeof magic) == 0 && head.length > 0 &&
        head.length <= ENTRY_MAX)
        binary = calloc(head.length + SLACK, 1);
    if (binary &&
        (fread(binary, 1, head.length, f) != head.length || fgetc(f) != EOF || !believable(cache, &head, binary))) {
        free(binary);
        binary = NULL;
    }
    fclose(f);
    if (binary)
        *size = head.length;
    return binary;
}

bool ost_cl_cache_store(const ost_cl_cache *cache, const unsigned char *binary, size_t size)
{
    entry_head head = {.length = size, .key = cache->key};
    memcpy(head.magic, magic, sizeof magic);
    if (!cache->folder[0] || size == 0 || size > ENTRY_MAX || ost_digest_bytes(binary, size, &head.checksum, NULL) != OST_OK)
        return false;

    char parent[sizeof cache->folder], fresh[sizeof cache->path + 16];
    snprintf(parent, sizeof parent, "%s", cache->folder);
    *strrchr(parent, '/') = 0;
    mkdir(parent, 0700); /* the last two levels; what is above is the user's affair */
    mkdir(cache->folder, 0700);
    snprintf(fresh, sizeof fresh, "%s.XXXXXX", cache->path);
    int fd = mkstemp(fresh);
    FILE *f = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (!f) {
        if (fd >= 0) {
            close(fd);
            unlink(fresh);
        }
        return false;
    }
    bool whole = fwrite(&head, sizeof head, 1, f) == 1 && fwrite(binary, 1, size, f) == size;
    whole = fclose(f) == 0 && whole;
    whole = whole && rename(fresh, cache->path) == 0;
    if (!whole)
        unlink(fresh);
    return whole;
}
