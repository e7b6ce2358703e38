/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A cache of built programs: $XDG_CACHE_HOME/osteon (or ~/.cache/osteon), one
 * file per program, named by its key.
 *
 *   key       SHA-256 of everything that a binary depends on (key.c)
 *   entry     "OSTCLB01" | length u64 | key 32 | SHA-256 of the binary 32 | the binary
 *
 * An entry is used only if all these fields match.  An entry that is truncated,
 * changed or of another key is ignored and written anew.  A missing cache is not
 * an error: programs are then built each time.
 *
 * A binary is code that this process runs, so a cache is used only if nobody
 * but its user can have written it: folder and entry belong to the effective
 * user, neither group nor others have write permission, and neither is a
 * symbolic link.  Any other folder is neither read nor written.
 */
#ifndef OST_CL_CACHE_H
#define OST_CL_CACHE_H

#include <osteon/digest.h>

typedef struct ost_cl_cache {
    char folder[1024]; /* "" if there is no folder for a cache */
    char entry[80];    /* file name of the entry in the folder */
    ost_digest key;
} ost_cl_cache;

/* Computes the key from count strings and sets the entry's name. Each string is hashed with its length, so that
   different divisions of the same text give different keys. */
ost_status ost_cl_cache_key(ost_cl_cache *cache, const char *const *parts, size_t count, ost_error *err);
/* Returns the binary, to be freed by the caller, or NULL if there is no valid entry. */
unsigned char *ost_cl_cache_load(const ost_cl_cache *cache, size_t *size);
/* Writes the entry completely or not at all, also if several programs write it at once. Returns false if nothing was
   written. */
bool ost_cl_cache_store(const ost_cl_cache *cache, const unsigned char *binary, size_t size);

#endif
