/* SPDX-License-Identifier: Apache-2.0 */
/* Facts that travel with a grid. */
#include <osteon/grid.h>

#include <string.h>

static int find(const ost_meta *meta, const char *key)
{
    for (int i = 0; i < meta->count; i++)
        if (strcmp(meta->entry[i].key, key) == 0)
            return i;
    return -1;
}

const char *ost_meta_get(const ost_meta *meta, const char *key)
{
    int i = find(meta, key);
    return i < 0 ? NULL : meta->entry[i].value;
}

static bool key_is_good(const char *key)
{
    size_t length = strlen(key);
    return length >= 1 && length < OST_META_KEY && strspn(key, "abcdefghijklmnopqrstuvwxyz0123456789_") == length;
}

static bool value_is_good(const char *value)
{
    if (strlen(value) >= OST_META_VALUE)
        return false;
    for (const unsigned char *p = (const unsigned char *)value; *p; p++)
        if (*p < 0x20 || *p == 0x7f)
            return false;
    return true;
}

ost_status ost_meta_set(ost_meta *meta, const char *key, const char *value, ost_error *err)
{
    if (!key_is_good(key))
        return ost_fail(err, OST_ERR_RANGE, "'%.60s' is not a key; keys are 1 to %d of a-z, 0-9 and _", key, OST_META_KEY - 1);
    if (!value_is_good(value))
        return ost_fail(err, OST_ERR_RANGE, "the value of '%s' is not one printable line of at most %d bytes", key, OST_META_VALUE - 1);
    int i = find(meta, key);
    if (i < 0) {
        if (meta->count == OST_META_MAX)
            return ost_fail(err, OST_ERR_RANGE, "no room for '%s': at most %d keys", key, OST_META_MAX);
        i = meta->count++;
    }
    /* Both may be this entry's own, as ost_meta_get gave them. */
    memmove(meta->entry[i].key, key, strlen(key) + 1);
    memmove(meta->entry[i].value, value, strlen(value) + 1);
    return OST_OK;
}
