/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A cache of built programs: $XDG_CACHE_HOME/osteon (or ~/.cache/osteon), one
 * file a program, named by its key.
 *
 *   key       SHA-256 of all that a binary depends on (key.c)
 *   entry     "OSTCLB01" | length u64 | key 32 | SHA-256 of the binary 32 | the binary
 *
 * An entry is believed only if all of it is what it says: one that is cut,
 * changed, or belongs to another key is as good as none, and is written anew.
 * No cache is no failure either: then programs are built each time.
 *
 * A binary is code that this process runs, so a cache is used only when nobody
 * but its user can have written it: folder and entry belong to the effective
 * user, neither group nor others may write them, and neither is a symbolic
 * link.  Any other folder is neither read nor written.
 */
#ifndef OST_CL_CACHE_H
#define OST_CL_CACHE_H

#include <osteon/digest.h>

typedef struct ost_cl_cache {
    char folder[1024]; /* "" when there is nowhere to keep anything */
    char entry[80];    /* its name in the folder */
    ost_digest key;
} ost_cl_cache;

/* parts of the key: each counts with its length, so that none runs into the next. */
ost_status ost_cl_cache_key(ost_cl_cache *cache, const char *const *parts, size_t count, ost_error *err);
/* The binary, to be freed by the caller, or NULL. */
unsigned char *ost_cl_cache_load(const ost_cl_cache *cache, size_t *size);
/* Whole or not at all, also when several programs write it at once. False when nothing was written. */
bool ost_cl_cache_store(const ost_cl_cache *cache, const unsigned char *binary, size_t size);

#endif
