/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes and checks the signatures of a bundle, which are in its folder signatures/.
 *
 *   manifest.json, protocol.json, cases.jsonl --> in-toto statement v1 with a test-result v0.1 predicate
 *                                                       |
 *   private key (PEM) --------------------------------> DSSE envelope: signatures/TIME-KEY.intoto.jsonl
 *   time-stamping authority (RFC 3161), optional -----> the same name followed by .tsr
 *
 * A statement consists of the signer's claims (name, meaning, time) and of values that are derived from the
 * bundle. Verification derives these values again and compares them. A key is identified by its
 * fingerprint, the SHA-256 of the DER form of the public key.
 */
#ifndef OST_VALIDATION_SIGN_H
#define OST_VALIDATION_SIGN_H

#include <jansson.h>

#include "validation/bundle/bundle.h"

/* A private key, Ed25519 or ECDSA P-256. Freed by sign_key_free, which clears it. */
typedef struct sign_key sign_key;

/*
 * Reads a private key from a PEM file. The passphrase of an encrypted key is the first line of the file
 * `passphrase`. If `passphrase` is NULL and standard input is a terminal, OpenSSL prompts for the passphrase. If
 * it is NULL and standard input is not a terminal, an encrypted key is an error.
 */
ost_status sign_key_open(const char *path, const char *passphrase, sign_key **out, ost_error *err);
void sign_key_free(sign_key *key); /* NULL is allowed */

/* SIGN_TEXT_MAX: maximum length in bytes of a signer's name and of a meaning. SIGN_NAME: size of a buffer for a file
   name. */
enum { SIGN_TEXT_MAX = 200, SIGN_NAME = 128 };

/*
 * Signs the bundle in `folder` and writes the envelope. The caller must check the bundle first. `by` is the signer's
 * printed name and may be "". `meaning` is a string such as "reviewed and accepted". Sets `name` to the envelope's
 * name within the folder.
 */
ost_status sign_bundle(const char *folder, const sign_key *key, const char *by, const char *meaning,
                       char name[SIGN_NAME], ost_error *err);

/* Trusted public keys, and the certificates of a time-stamping authority. */
typedef struct sign_trust sign_trust;

/* Reads the trusted keys. `paths` lists PEM files of public keys or folders of such files. `authority` is a PEM file
   of certificates, or NULL. */
ost_status sign_trust_open(const char *const paths[], int count, const char *authority, sign_trust **out,
                           ost_error *err);
void sign_trust_free(sign_trust *trust); /* NULL is allowed */

/*
 * Checks every file in signatures/. If `trust` is not NULL, there must be at least one signature, and each
 * signature must be by a trusted key. If `trust` is NULL, envelopes are read and compared with the bundle,
 * but no signature is verified. Sets *out to [{file, by, meaning, claimed_time, keys[], checked, stamped,
 * time_stamp}], which the caller owns.
 */
ost_status sign_check(const char *folder, const sign_trust *trust, bundle_problem *problem, void *user, int *found,
                      json_t **out, ost_error *err);

#endif
