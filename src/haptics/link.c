/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/link.h"

#include <errno.h>
#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/params.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"

/* ------------------------------------------------------------------ bytes */

static const uint8_t magic[4] = {'O', 'S', 'T', 'L'};
enum {
    AT_VERSION = 4, AT_TYPE = 5, AT_FLAGS = 6, AT_BRIDGE = 8, AT_SIMULATION = 16, AT_SEQUENCE = 24,
    AT_BODY = 32,   /* offset of a 64-bit integer: `t_ns` (signed) or `answers` (unsigned) */
    AT_POSE = 40,   /* offset of the pose: three 64-bit and four 32-bit signed integers */
    AT_BUTTONS = 80, AT_TOOL = 84,
    AT_FORCE = 80, AT_TORQUE = 92, AT_STIFFNESS = 104, AT_DAMPING = 108
};

static void put(uint8_t *p, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        p[i] = (uint8_t)(value >> 8 * i);
}

static uint64_t get(const uint8_t *p, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)p[i] << 8 * i;
    return value;
}

static int32_t get32(const uint8_t *p)
{
    return (int32_t)(uint32_t)get(p, 4);
}

static size_t body_of(uint8_t type)
{
    return (type == LINK_STATE ? LINK_STATE_BYTES : LINK_POSE_BYTES) - LINK_MAC;
}

size_t ost_link_encode(const link_packet *packet, uint8_t b[LINK_STATE_BYTES])
{
    const ost_pose *p = &packet->pose;
    const int64_t t[3] = {p->t.x, p->t.y, p->t.z};
    const int32_t q[4] = {p->qw, p->qx, p->qy, p->qz};
    memcpy(b, magic, sizeof magic);
    b[AT_VERSION] = LINK_VERSION;
    b[AT_TYPE] = packet->type;
    put(b + AT_FLAGS, packet->flags, 2);
    put(b + AT_BRIDGE, packet->bridge, 8);
    put(b + AT_SIMULATION, packet->simulation, 8);
    put(b + AT_SEQUENCE, packet->sequence, 8);
    put(b + AT_BODY, packet->type == LINK_STATE ? packet->answers : (uint64_t)packet->t_ns, 8);
    for (int i = 0; i < 3; i++)
        put(b + AT_POSE + 8 * i, (uint64_t)t[i], 8);
    for (int i = 0; i < 4; i++)
        put(b + AT_POSE + 24 + 4 * i, (uint32_t)q[i], 4);
    if (packet->type == LINK_STATE) {
        for (int i = 0; i < 3; i++) {
            put(b + AT_FORCE + 4 * i, (uint32_t)packet->force_un[i], 4);
            put(b + AT_TORQUE + 4 * i, (uint32_t)packet->torque_unm[i], 4);
        }
        put(b + AT_STIFFNESS, packet->stiffness, 4);
        put(b + AT_DAMPING, packet->damping, 4);
    } else {
        put(b + AT_BUTTONS, packet->buttons, 4);
        put(b + AT_TOOL, (uint32_t)packet->tool, 4);
    }
    return body_of(packet->type);
}

bool ost_link_decode(const uint8_t *b, size_t size, link_packet *out)
{
    *out = (link_packet){0};
    if (size < AT_BODY || memcmp(b, magic, sizeof magic) != 0 || b[AT_VERSION] != LINK_VERSION)
        return false;
    out->type = b[AT_TYPE];
    if (out->type < LINK_HELLO || out->type > LINK_STATE || size != body_of(out->type))
        return false;
    const uint16_t allowed = out->type == LINK_STATE  ? LINK_ENDED | LINK_AGAIN | LINK_BUSY
                             : out->type == LINK_POSE ? LINK_SEEN | LINK_ENDED
                                                      : 0;
    out->flags = (uint16_t)get(b + AT_FLAGS, 2);
    out->bridge = get(b + AT_BRIDGE, 8);
    out->simulation = get(b + AT_SIMULATION, 8);
    out->sequence = get(b + AT_SEQUENCE, 8);
    if (out->type == LINK_STATE)
        out->answers = get(b + AT_BODY, 8);
    else
        out->t_ns = (int64_t)get(b + AT_BODY, 8);
    out->pose = (ost_pose){
        .t = {(int64_t)get(b + AT_POSE, 8), (int64_t)get(b + AT_POSE + 8, 8), (int64_t)get(b + AT_POSE + 16, 8)},
        .qw = get32(b + AT_POSE + 24),
        .qx = get32(b + AT_POSE + 28),
        .qy = get32(b + AT_POSE + 32),
        .qz = get32(b + AT_POSE + 36)};
    if (out->type == LINK_STATE) {
        for (int i = 0; i < 3; i++) {
            out->force_un[i] = get32(b + AT_FORCE + 4 * i);
            out->torque_unm[i] = get32(b + AT_TORQUE + 4 * i);
        }
        out->stiffness = (uint32_t)get(b + AT_STIFFNESS, 4);
        out->damping = (uint32_t)get(b + AT_DAMPING, 4);
    } else {
        out->buttons = (uint32_t)get(b + AT_BUTTONS, 4);
        out->tool = get32(b + AT_TOOL);
    }
    const bool posed = out->type == LINK_STATE || (out->flags & LINK_SEEN);
    return !(out->flags & ~allowed) && out->tool >= -1 && (!posed || ost_pose_check(&out->pose, NULL) == OST_OK);
}

/* ------------------------------------------------------------------- keys */

struct link_key {
    EVP_MAC *mac;
    EVP_MAC_CTX *context;
};

ost_status ost_link_key_make(const void *bytes, size_t size, link_key **out, ost_error *err)
{
    *out = NULL;
    if (size < LINK_KEY_MIN || size > LINK_KEY_MAX)
        return ost_fail(err, OST_ERR_INPUT, "the key has %zu bytes; expected %d to %d", size, LINK_KEY_MIN,
                        LINK_KEY_MAX);
    link_key *key = calloc(1, sizeof *key);
    if (!key)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a key");
    char digest[] = "SHA256";
    const OSSL_PARAM params[] = {OSSL_PARAM_construct_utf8_string(OSSL_MAC_PARAM_DIGEST, digest, 0),
                                 OSSL_PARAM_construct_end()};
    key->mac = EVP_MAC_fetch(NULL, "HMAC", NULL);
    key->context = key->mac ? EVP_MAC_CTX_new(key->mac) : NULL;
    if (!key->context || EVP_MAC_init(key->context, bytes, size, params) != 1) {
        ost_link_key_free(key);
        return ost_fail(err, OST_ERR_INTERNAL, "libcrypto has no HMAC-SHA-256");
    }
    *out = key;
    return OST_OK;
}

void ost_link_key_free(link_key *key)
{
    if (!key)
        return;
    EVP_MAC_CTX_free(key->context);
    EVP_MAC_free(key->mac);
    free(key);
}

ost_status ost_link_key_read(const char *path, link_key **out, ost_error *err)
{
    uint8_t bytes[LINK_KEY_MAX + 1];
    struct stat st;
    ost_file file;
    ost_error why = {0};
    *out = NULL;
    ost_status status = ost_file_open(path, &file, &why);
    if (status != OST_OK)
        return ost_fail(err, status,
                        file.absent ? "%s; to create a key: (umask 077; head -c 32 /dev/urandom >%s)" : "%s", why.text,
                        path);
    const int fd = file.fd;
    ssize_t size = -1;
    if (fstat(fd, &st) != 0)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    else if (st.st_mode & (S_IRWXG | S_IRWXO))
        status = ost_fail(err, OST_ERR_USAGE, "%s: other users can read this key; run chmod 600 %s", path, path);
    else if ((size = read(fd, bytes, sizeof bytes)) < 0)
        status = ost_fail(err, OST_ERR_IO, "%s: read failed: %s", path, strerror(errno));
    close(fd);
    if (status == OST_OK) {
        status = ost_link_key_make(bytes, (size_t)size, out, err);
        if (status != OST_OK)
            (void)ost_fail_context(err, "%s", path);
    }
    OPENSSL_cleanse(bytes, sizeof bytes);
    return status;
}

static bool sign(link_key *key, const uint8_t *bytes, size_t size, uint8_t mac[LINK_MAC])
{
    size_t length = 0;
    /* If the key is NULL, EVP_MAC_init starts again with the key that was set in ost_link_key_make. */
    return EVP_MAC_init(key->context, NULL, 0, NULL) == 1 && EVP_MAC_update(key->context, bytes, size) == 1 &&
           EVP_MAC_final(key->context, mac, &length, LINK_MAC) == 1 && length == LINK_MAC;
}

size_t ost_link_seal(link_key *key, const link_packet *packet, uint8_t bytes[LINK_STATE_BYTES])
{
    const size_t body = ost_link_encode(packet, bytes);
    return sign(key, bytes, body, bytes + body) ? body + LINK_MAC : 0;
}

link_verdict ost_link_unseal(link_key *key, const uint8_t *bytes, size_t size, link_packet *out)
{
    uint8_t mac[LINK_MAC];
    /* The packet's form is checked before the HMAC is computed, so that a flood of malformed packets takes little
       time. */
    if (size < LINK_MAC || !ost_link_decode(bytes, size - LINK_MAC, out))
        return LINK_MALFORMED;
    if (!sign(key, bytes, size - LINK_MAC, mac) || CRYPTO_memcmp(mac, bytes + size - LINK_MAC, LINK_MAC) != 0)
        return LINK_WRONG_KEY;
    return LINK_GOOD;
}

/* ---------------------------------------------------------------- numbers */

link_order ost_link_window_add(link_window *w, uint64_t sequence, uint64_t *lost)
{
    *lost = 0;
    if (sequence > w->last) {
        const uint64_t ahead = sequence - w->last;
        *lost = ahead - 1;
        w->seen = (ahead < 64 ? w->seen << ahead : 0) | 1;
        w->last = sequence;
        return LINK_NEW;
    }
    const uint64_t behind = w->last - sequence;
    if (behind >= 64 || (w->seen >> behind & 1))
        return LINK_REPLAYED;
    w->seen |= UINT64_C(1) << behind;
    return LINK_LATE;
}

bool ost_link_random(uint64_t *out)
{
    *out = 0;
    while (*out == 0)
        if (getrandom(out, sizeof *out, 0) != (ssize_t)sizeof *out && errno != EINTR)
            return false;
    return true;
}
