/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes and reads envelopes of DSSE 1.0.2 (github.com/secure-systems-lab/dsse, protocol.md and
 * envelope.md):
 *
 *   PAE(type, body) = "DSSEv1" SP LEN(type) SP type SP LEN(body) SP body
 *   {"payload": base64(body), "payloadType": type, "signatures": [{"keyid", "sig": base64}]}
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/sign_parts.h"

#define PAYLOAD_TYPE "application/vnd.in-toto+json"

static ost_status encode(const char *payload, size_t size, char **out, size_t *out_size, ost_error *err)
{
    char head[96];
    const int n = snprintf(head, sizeof head, "DSSEv1 %zu %s %zu ", strlen(PAYLOAD_TYPE), PAYLOAD_TYPE, size);
    *out_size = (size_t)n + size;
    *out = malloc(*out_size);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an envelope");
    memcpy(*out, head, (size_t)n);
    memcpy(*out + n, payload, size);
    return OST_OK;
}

/* --------------------------------------------------------------- base64 */

static char *to_base64(const unsigned char *bytes, size_t size)
{
    char *text = size < INT32_MAX / 2 ? malloc(4 * ((size + 2) / 3) + 1) : NULL;
    if (text)
        EVP_EncodeBlock((unsigned char *)text, bytes, (int)size);
    return text;
}

static int digit_of(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Decodes base64 of RFC 4648, standard or URL-safe, with padding, and with all unused bits 0. Returns NULL for any
   other text, or if memory is exhausted. */
static unsigned char *from_base64(const char *text, size_t length, size_t *size)
{
    const size_t pad = length && text[length - 1] == '=' ? length > 1 && text[length - 2] == '=' ? 2 : 1 : 0;
    unsigned char *bytes = length % 4 == 0 ? malloc(length / 4 * 3 + 1) : NULL;
    uint32_t word = 0;
    *size = 0;
    for (size_t i = 0; bytes && i < length - pad; i++) {
        const int digit = digit_of(text[i]);
        if (digit < 0) {
            free(bytes);
            return NULL;
        }
        word = word << 6 | (uint32_t)digit;
        if (i % 4)
            bytes[(*size)++] = (unsigned char)(word >> (6 - 2 * (i % 4)));
    }
    if (bytes && (word & ((1u << 2 * pad) - 1))) {
        free(bytes);
        return NULL;
    }
    if (bytes)
        bytes[*size] = '\0';
    return bytes;
}

/* ------------------------------------------------------------- envelopes */

ost_status sign_envelope_make(const sign_key *key, const char *payload, size_t size, char **text, ost_error *err)
{
    char *encoded = NULL;
    unsigned char *signature = NULL;
    size_t encoded_size, signature_size;
    *text = NULL;
    ost_status status = encode(payload, size, &encoded, &encoded_size, err);
    if (status == OST_OK)
        status = sign_make(key, encoded, encoded_size, &signature, &signature_size, err);
    if (status == OST_OK) {
        char *body = to_base64((const unsigned char *)payload, size), *sig = to_base64(signature, signature_size);
        json_t *o = body && sig ? json_pack("{s:s,s:s,s:[{s:s,s:s}]}", "payload", body, "payloadType", PAYLOAD_TYPE,
                                            "signatures", "keyid", key->fingerprint, "sig", sig)
                                : NULL;
        *text = o ? json_dumps(o, JSON_COMPACT | JSON_SORT_KEYS) : NULL;
        if (!*text)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for an envelope");
        json_decref(o);
        free(body);
        free(sig);
    }
    free(encoded);
    free(signature);
    return status;
}

static bool is_fingerprint(const char *text)
{
    return strlen(text) == OST_DIGEST_HEX - 1 && strspn(text, "0123456789abcdef") == OST_DIGEST_HEX - 1;
}

/*
 * Reads one of the signatures of an envelope. If the signature is invalid, returns the reason. If it is valid, returns
 * NULL.
 */
static const char *read_signature(const json_t *one, sign_envelope *e)
{
    const json_t *sig = json_object_get(one, "sig"), *keyid = json_object_get(one, "keyid");
    if (!json_is_string(sig) || (keyid && !json_is_string(keyid)))
        return "has a signature that is not {keyid, sig} in text";
    e->signatures[e->count].bytes = from_base64(json_string_value(sig), json_string_length(sig),
                                                &e->signatures[e->count].size);
    if (!e->signatures[e->count].bytes)
        return "has a signature that is not base64 (RFC 4648, padded)";
    if (keyid && is_fingerprint(json_string_value(keyid)))
        memcpy(e->signatures[e->count].keyid, json_string_value(keyid), OST_DIGEST_HEX);
    e->count++;
    return NULL;
}

ost_status sign_envelope_read(const char *text, size_t size, sign_envelope *out, const char **why, ost_error *err)
{
    ost_status status = OST_OK;
    *out = (sign_envelope){.payload = NULL};
    json_t *o = json_loadb(text, size, JSON_REJECT_DUPLICATES, NULL);
    const json_t *payload = json_object_get(o, "payload"), *type = json_object_get(o, "payloadType"),
                 *list = json_object_get(o, "signatures");
    *why = NULL;
    if (!json_is_object(o))
        *why = "is not one JSON object (a DSSE envelope)";
    else if (!json_is_string(payload) || !json_is_string(type) || !json_is_array(list))
        *why = "is no DSSE envelope: it lacks payload, payloadType or signatures";
    else if (strcmp(json_string_value(type), PAYLOAD_TYPE) != 0)
        *why = "has another payloadType than " PAYLOAD_TYPE;
    else if (json_array_size(list) < 1 || json_array_size(list) > SIGN_SIGNATURES_MAX)
        *why = "has no signature, or more than 16";
    else if (!(out->payload = (char *)from_base64(json_string_value(payload), json_string_length(payload),
                                                  &out->payload_size)))
        *why = "has a payload that is not base64 (RFC 4648, padded)";
    for (size_t i = 0; !*why && i < json_array_size(list); i++)
        *why = read_signature(json_array_get(list, i), out);
    if (!*why)
        status = encode(out->payload, out->payload_size, &out->encoded, &out->encoded_size, err);
    json_decref(o);
    if (*why || status != OST_OK)
        sign_envelope_free(out);
    return status;
}

void sign_envelope_free(sign_envelope *e)
{
    for (int i = 0; i < e->count; i++)
        free(e->signatures[i].bytes);
    free(e->payload);
    free(e->encoded);
    *e = (sign_envelope){.payload = NULL};
}
