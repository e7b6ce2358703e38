/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shared libraries that this process runs with, drivers that were loaded
 * on the way among them: found by asking the loader, not the build.
 *
 *   loader's list --> path, build-id, size, SHA-256 --dpkg-query, where there is one--> package, version
 */
#ifndef OST_VALIDATION_LIBRARIES_H
#define OST_VALIDATION_LIBRARIES_H

#include <jansson.h>
#include <osteon/digest.h>

/* [{file, soname, linked, build_id, size, sha256, package, version, maintainer}] sorted by file; the caller's reference. */
ost_status libraries_loaded(json_t **out, ost_error *err);

/* The digest of a file, in hexadecimal. */
ost_status libraries_digest(const char *path, char hex[OST_DIGEST_HEX], int64_t *size, ost_error *err);

#endif
