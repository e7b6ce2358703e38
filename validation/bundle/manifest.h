/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes manifest.json, which lists every file of a bundle with its size and SHA-256, sorted by name, and
 * contains two root digests:
 *
 *   root          all files
 *   results_root  the files whose content depends only on the cases, the code and the list of backends (see
 *                 folder.c); two runs with the same list have the same results_root, independently of the
 *                 machine, its drivers and the time
 *
 * A root digest is the Merkle tree hash of RFC 6962, section 2.1. The tree has one leaf for each file, with
 * the hash SHA-256(0x00 || name || 0x00 || digest of the file). The text of the manifest is canonical, so any
 * change of a byte in the manifest itself is detected. The manifest does not list signatures/, because a
 * signature covers the manifest.
 */
#ifndef OST_VALIDATION_MANIFEST_H
#define OST_VALIDATION_MANIFEST_H

#include "validation/bundle/bundle.h"

#define MANIFEST_FILE "manifest.json"
#define MANIFEST_SIGNATURES "signatures"

/* Computes the manifest of the files that are now in the folder. The caller owns *out. */
ost_status manifest_of(const char *folder, json_t **out, ost_error *err);
/* Returns the text of the manifest file; the caller frees it. */
char *manifest_text(const json_t *manifest);
ost_status manifest_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err);

#endif
