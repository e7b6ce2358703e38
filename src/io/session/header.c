/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Encodes and decodes a session's header, which consists of lines "key: value". In a value, a backslash and every
 * byte that is below 32 or equal to 127 are written as \xHH. Each entry is therefore one line, and a value can
 * contain any file name. The text is padded with zeros to a multiple of 64 bytes.
 */
#include "io/session/layout.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct header_entry {
    char key[OST_SESSION_KEY];
    char *value; /* owned */
} header_entry;

struct ost_session_header {
    int count;
    header_entry entry[OST_SESSION_KEYS_MAX];
};

ost_status ost_session_header_create(ost_session_header **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a session's header");
}

void ost_session_header_free(ost_session_header *header)
{
    if (!header)
        return;
    for (int i = 0; i < header->count; i++)
        free(header->entry[i].value);
    free(header);
}

static header_entry *find(const ost_session_header *header, const char *key)
{
    for (int i = 0; i < header->count; i++)
        if (strcmp(header->entry[i].key, key) == 0)
            return (header_entry *)(uintptr_t)&header->entry[i];
    return NULL;
}

static bool key_is_allowed(const char *key)
{
    const size_t length = strspn(key, "abcdefghijklmnopqrstuvwxyz0123456789_.");
    return length > 0 && length < OST_SESSION_KEY && key[length] == '\0';
}

ost_status ost_session_header_set(ost_session_header *header, const char *key, const char *value, ost_error *err)
{
    if (!key_is_allowed(key))
        return ost_fail(err, OST_ERR_RANGE,
                        "'%.50s' is not a key of a session's header; expected up to %d of a-z, 0-9, _ and .", key,
                        OST_SESSION_KEY - 1);
    if (strlen(value) > OST_SESSION_VALUE)
        return ost_fail(err, OST_ERR_RANGE, "the value of '%s' has %zu bytes; a session's header holds up to %d", key,
                        strlen(value), OST_SESSION_VALUE);
    header_entry *entry = find(header, key);
    if (!entry && header->count == OST_SESSION_KEYS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a session's header holds up to %d keys; '%s' is one too many",
                        OST_SESSION_KEYS_MAX, key);
    char *copy = strdup(value);
    if (!copy)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a session's header");
    if (entry) {
        free(entry->value);
    } else {
        entry = &header->entry[header->count++];
        memcpy(entry->key, key, strlen(key) + 1);
    }
    entry->value = copy;
    return OST_OK;
}

const char *ost_session_header_get(const ost_session_header *header, const char *key)
{
    const header_entry *entry = find(header, key);
    return entry ? entry->value : NULL;
}

int ost_session_header_count(const ost_session_header *header)
{
    return header->count;
}

void ost_session_header_entry(const ost_session_header *header, int index, const char **key, const char **value)
{
    *key = header->entry[index].key;
    *value = header->entry[index].value;
}

/* ------------------------------------------------------- encoding, decoding */

static bool is_escaped(unsigned char c)
{
    return c < 32 || c == 127 || c == '\\';
}

ost_status ost_session_header_encode(const ost_session_header *header, unsigned char **out, uint32_t *size,
                                     ost_error *err)
{
    size_t capacity = 0;
    for (int i = 0; i < header->count; i++)
        capacity += strlen(header->entry[i].key) + 3 + 4 * strlen(header->entry[i].value);
    capacity = (capacity + SESSION_ALIGN) / SESSION_ALIGN * SESSION_ALIGN;
    unsigned char *bytes = calloc(1, capacity + SESSION_ALIGN), *p = bytes;
    if (!bytes)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a session's header");
    for (int i = 0; i < header->count; i++) {
        p += sprintf((char *)p, "%s: ", header->entry[i].key);
        for (const char *v = header->entry[i].value; *v; v++) {
            if (is_escaped((unsigned char)*v))
                p += sprintf((char *)p, "\\x%02x", (unsigned char)*v);
            else
                *p++ = (unsigned char)*v;
        }
        *p++ = '\n';
    }
    size_t used = ((size_t)(p - bytes) + SESSION_ALIGN - 1) / SESSION_ALIGN * SESSION_ALIGN;
    used = used ? used : SESSION_ALIGN;
    if (used > SESSION_PAYLOAD_MAX) {
        free(bytes);
        return ost_fail(err, OST_ERR_RANGE, "a session's header of %zu bytes; expected up to %d", used,
                        SESSION_PAYLOAD_MAX);
    }
    *out = bytes;
    *size = (uint32_t)used;
    return OST_OK;
}

static int hex(unsigned char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Replaces the escapes in a value. Returns false if an escape is malformed or the value is too long. */
static bool unescape(const unsigned char *p, const unsigned char *end, char value[OST_SESSION_VALUE + 1])
{
    size_t n = 0;
    while (p < end) {
        unsigned char c = *p++;
        if (c == '\\') {
            if (end - p < 3 || p[0] != 'x' || hex(p[1]) < 0 || hex(p[2]) < 0)
                return false;
            c = (unsigned char)(hex(p[1]) << 4 | hex(p[2]));
            p += 3;
        }
        if (c == '\0' || n == OST_SESSION_VALUE)
            return false;
        value[n++] = (char)c;
    }
    value[n] = '\0';
    return true;
}

ost_status ost_session_header_decode(const unsigned char *in, size_t size, ost_session_header **out, ost_error *err)
{
    char key[OST_SESSION_KEY], value[OST_SESSION_VALUE + 1];
    const unsigned char *p = in, *end = memchr(in, '\0', size);
    end = end ? end : in + size;
    ost_status status = ost_session_header_create(out, err);
    while (status == OST_OK && p < end) {
        const unsigned char *line_end = memchr(p, '\n', (size_t)(end - p));
        const unsigned char *colon = line_end ? memchr(p, ':', (size_t)(line_end - p)) : NULL;
        if (!colon || colon - p >= OST_SESSION_KEY || colon[1] != ' ' || !unescape(colon + 2, line_end, value)) {
            status = ost_fail(err, OST_ERR_INPUT, "byte %zu of the header's text does not begin a line \"key: value\"",
                              (size_t)(p - in));
            break;
        }
        memcpy(key, p, (size_t)(colon - p));
        key[colon - p] = '\0';
        status = ost_session_header_set(*out, key, value, err);
        p = line_end + 1;
    }
    if (status != OST_OK) {
        ost_session_header_free(*out);
        *out = NULL;
    }
    return status;
}
