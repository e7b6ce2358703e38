/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the shared libraries that this process has loaded, including drivers that were loaded at run time.
 * The list comes from the dynamic loader, not from the build.
 *
 *   loader's list --> path, build-id, size, SHA-256 --dpkg-query, if installed--> package, version
 */
#ifndef OST_VALIDATION_LIBRARIES_H
#define OST_VALIDATION_LIBRARIES_H

#include <jansson.h>
#include <osteon/digest.h>

/* Makes [{file, soname, linked, build_id, size, sha256, package, version, licence, maintainer}], sorted by file; owned
   by the caller. */
ost_status libraries_loaded(json_t **out, ost_error *err);

/* Computes the SHA-256 of a file in hexadecimal. */
ost_status libraries_digest(const char *path, char hex[OST_DIGEST_HEX], int64_t *size, ost_error *err);

#endif
