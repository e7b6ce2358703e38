/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the facts of a grid, which files store together with its voxels (grid.h). */
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

bool ost_meta_key_is_geometry(const char *key)
{
    return strcmp(key, "dims") == 0 || strcmp(key, "spacing_mm") == 0 || strcmp(key, "origin_mm") == 0;
}

static bool value_is_good(const char *value, size_t length)
{
    if (length >= OST_META_VALUE)
        return false;
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)value[i] < 0x20 || value[i] == 0x7f)
            return false;
    return true;
}

ost_status ost_meta_set(ost_meta *meta, const char *key, const char *value, ost_error *err)
{
    if (!key_is_good(key))
        return ost_fail(err, OST_ERR_RANGE, "'%.60s' is not a key; keys are 1 to %d of a-z, 0-9 and _", key,
                        OST_META_KEY - 1);
    value += strspn(value, " ");
    size_t length = strlen(value);
    while (length > 0 && value[length - 1] == ' ')
        length--;
    if (!value_is_good(value, length))
        return ost_fail(err, OST_ERR_RANGE, "the value of '%s' is not one printable line of at most %d bytes", key,
                        OST_META_VALUE - 1);
    int i = find(meta, key);
    if (i < 0) {
        if (meta->count == OST_META_MAX)
            return ost_fail(err, OST_ERR_RANGE, "too many keys: '%s'; expected at most %d", key, OST_META_MAX);
        i = meta->count++;
    }
    /*
     * The pointers `key` and `value` may point into this entry, because ost_meta_get returns pointers to the stored
     * values.
     */
    memmove(meta->entry[i].key, key, strlen(key) + 1);
    memmove(meta->entry[i].value, value, length);
    meta->entry[i].value[length] = 0;
    return OST_OK;
}
