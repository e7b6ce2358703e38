/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A cache of built programs: $XDG_CACHE_HOME/osteon (or ~/.cache/osteon), one
 * file per program, named by its key.
 *
 *   key       SHA-256 of everything that a binary depends on (key.c)
 *   entry     "OSTCLB01" | length u64 | key 32 | SHA-256 of the binary 32 | the binary
 *
 * An entry is used only if all these fields match.  An entry that is truncated or modified, or that
 * has a different key, is ignored and replaced.  If there is no cache, programs are built each
 * time; this is not an error.
 *
 * This process executes the binaries in the cache, so the cache is used only if no other user can
 * have written to it.  The folder and the entry must belong to the effective user, must not be
 * writable by the group or by others, and must not be symbolic links.  A folder that does not
 * satisfy these conditions is neither read nor written.
 */
#ifndef OST_CL_CACHE_H
#define OST_CL_CACHE_H

#include <osteon/digest.h>

typedef struct ost_cl_cache {
    char folder[1024]; /* path of the cache's folder; "" if no folder was found */
    char entry[80];    /* file name of the entry, without the folder */
    ost_digest key;
} ost_cl_cache;

/* Computes the key from `count` strings and sets the name of the entry. Each string is hashed with its length, so that
   different divisions of the same text into strings result in different keys. */
ost_status ost_cl_cache_key(ost_cl_cache *cache, const char *const *parts, size_t count, ost_error *err);
/* Returns the binary of the entry, or NULL if there is no valid entry. The caller frees the binary. */
unsigned char *ost_cl_cache_load(const ost_cl_cache *cache, size_t *size);
/* Writes the entry either completely or not at all, even if several programs write it at the same time. Returns false
   if nothing was written. */
bool ost_cl_cache_store(const ost_cl_cache *cache, const unsigned char *binary, size_t size);

#endif
