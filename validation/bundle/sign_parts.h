/* SPDX-License-Identifier: Apache-2.0 */
/* The types and functions that the parts of sign.h share: envelopes (DSSE 1.0.2), keys, time stamps (RFC 3161). */
#ifndef OST_VALIDATION_SIGN_PARTS_H
#define OST_VALIDATION_SIGN_PARTS_H

#include <openssl/evp.h>
#include <openssl/x509.h>

#include "validation/bundle/sign.h"

enum { SIGN_KEYS_MAX = 64, SIGN_SIGNATURES_MAX = 16 };

struct sign_key {
    EVP_PKEY *key;
    char fingerprint[OST_DIGEST_HEX];
};

struct sign_trust {
    sign_key keys[SIGN_KEYS_MAX];
    int count;
    X509_STORE *authority; /* certificates of the time-stamping authority; NULL if time stamps are not checked */
};

/* ---------------------------------------------------------- sign_key.c */

/* Signs bytes that are already in the pre-authentication encoding (PAE). The caller frees *signature. */
ost_status sign_make(const sign_key *key, const void *bytes, size_t size, unsigned char **signature,
                     size_t *signature_size, ost_error *err);
bool sign_holds(const sign_key *key, const void *bytes, size_t size, const unsigned char *signature,
                size_t signature_size);

/* ----------------------------------------------------- sign_envelope.c */

typedef struct sign_envelope {
    char *payload; /* the bytes of the statement; owned, like all other pointers of this struct */
    size_t payload_size;
    char *encoded; /* PAE(type, payload), the bytes that were signed */
    size_t encoded_size;
    int count;
    struct {
        unsigned char *bytes;
        size_t size;
        /* fingerprint of the key, as the envelope states it; not signed, so it is only a hint; "" if it is malformed */
        char keyid[OST_DIGEST_HEX];
    } signatures[SIGN_SIGNATURES_MAX];
} sign_envelope;

/* Makes an envelope for the payload as one line of JSON. The caller frees *text. */
ost_status sign_envelope_make(const sign_key *key, const char *payload, size_t size, char **text, ost_error *err);
/* Reads an envelope. If the text is invalid, sets *why to the reason. If it is valid, sets *why to NULL. Fails only
   with OST_ERR_MEMORY. */
ost_status sign_envelope_read(const char *text, size_t size, sign_envelope *out, const char **why, ost_error *err);
void sign_envelope_free(sign_envelope *e);

/* ----------------------------------------------------- sign_time.c */

enum { SIGN_TIME = 40 };
/* Reads the certificates of a time-stamping authority. */
ost_status sign_authority_open(const char *path, X509_STORE **out, ost_error *err);
/* Checks that `response` is a valid answer to a time stamp query that was made for `bytes`. If it is, returns NULL and
   writes the time of the stamp to `time`; otherwise, returns the reason. */
const char *sign_time_check(X509_STORE *authority, const char *response, size_t response_size, const char *bytes,
                            size_t size, char time[SIGN_TIME]);

#endif
