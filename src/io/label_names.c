/* SPDX-License-Identifier: Apache-2.0 */
#include "io/label_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <jansson.h>

#include "core/printable.h"
#include "io/small_text.h"

enum { FILE_MAX = 1 << 20, FIRST_CAPACITY = 16, LISTED = 300, ALIKE = 4 };

/* ------------------------------------------------------------------ the list */

/* Appends an empty name. If there are already OST_LABEL_NAMES_MAX names, sets *out to NULL. */
static ost_status append(ost_label_names *names, ost_label_name **out, ost_error *err)
{
    *out = NULL;
    if (names->count == OST_LABEL_NAMES_MAX)
        return OST_OK;
    /* The capacity is the smallest power of 2 that is at least FIRST_CAPACITY and at least the number of names. */
    if (names->count == 0 || (names->count >= FIRST_CAPACITY && (names->count & (names->count - 1)) == 0)) {
        const size_t capacity = names->count ? 2 * (size_t)names->count : FIRST_CAPACITY;
        ost_label_name *grown = realloc(names->items, capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu names of labels", capacity);
        names->items = grown;
    }
    *out = &names->items[names->count++];
    **out = (ost_label_name){.segment = -1, .value = -1};
    return OST_OK;
}

static void set_name(ost_label_name *item, const char *name, size_t length)
{
    const size_t most = sizeof item->name - 1;
    snprintf(item->name, sizeof item->name, "%.*s", (int)(length < most ? length : most), name);
    ost_make_printable(item->name);
}

/* Adds a name of `length` bytes for the label `value`. */
static ost_status add_name(ost_label_names *names, int32_t value, const char *name, size_t length, ost_error *err)
{
    ost_label_name *item;
    const ost_status status = append(names, &item, err);
    if (status == OST_OK && item) {
        item->value = value;
        set_name(item, name, length);
    }
    return status;
}

void ost_label_names_free(ost_label_names *names)
{
    free(names->items);
    *names = (ost_label_names){.count = 0};
}

/* Reads an integer from 0 to INT16_MAX at *text and moves *text past it. Returns -1 if there is none. */
static int32_t read_value(const char **text)
{
    int32_t value = 0;
    const char *p = *text;
    for (; *p >= '0' && *p <= '9'; p++)
        if ((value = 10 * value + (*p - '0')) > INT16_MAX)
            return -1;
    if (p == *text)
        return -1;
    *text = p;
    return value;
}

/* ------------------------------------------------------------- label maps */

ost_status ost_label_names_add_segment(ost_label_names *names, const char *key, const char *value, ost_error *err)
{
    static const char prefix[] = "Segment";
    if (strncmp(key, prefix, sizeof prefix - 1) != 0)
        return OST_OK;
    key += sizeof prefix - 1;
    const int32_t segment = read_value(&key);
    const bool is_name = strcmp(key, "_Name") == 0;
    if (segment < 0 || (!is_name && strcmp(key, "_LabelValue") != 0))
        return OST_OK;
    ost_label_name *item = NULL;
    /* The search begins with the last name, because the keys of a segment are usually adjacent. */
    for (int i = names->count - 1; i >= 0 && !item; i--)
        item = names->items[i].segment == segment ? &names->items[i] : NULL;
    const ost_status status = item ? OST_OK : append(names, &item, err);
    if (status != OST_OK || !item)
        return status;
    item->segment = segment;
    if (is_name)
        set_name(item, value, strlen(value));
    else
        item->value = read_value(&value);
    return OST_OK;
}

ost_status ost_label_names_add_xml(ost_label_names *names, const char *text, ost_error *err)
{
    static const char element[] = "<Label ", attribute[] = "Key=\"", cdata[] = "<![CDATA[";
    ost_status status = OST_OK;
    for (const char *at = strstr(text, element); at && status == OST_OK; at = strstr(at, element)) {
        at += sizeof element - 1;
        const char *end = strchr(at, '>'), *key = strstr(at, attribute);
        if (!end)
            return OST_OK;
        at = end + 1;
        if (!key || key > end)
            continue;
        key += sizeof attribute - 1;
        const int32_t value = read_value(&key);
        const bool is_cdata = strncmp(at, cdata, sizeof cdata - 1) == 0;
        const char *name = is_cdata ? at + sizeof cdata - 1 : at, *close = strstr(name, is_cdata ? "]]>" : "<");
        if (!close)
            return OST_OK;
        if (value >= 0 && *key == '"')
            status = add_name(names, value, name, (size_t)(close - name), err);
        at = close;
    }
    return status;
}

/* ---------------------------------------------------------------- a file */

static ost_status add_json(ost_label_names *names, const char *path, const char *text, size_t size, ost_error *err)
{
    json_error_t where;
    json_t *root = json_loadb(text, size, 0, &where);
    ost_status status = OST_OK;
    const char *key;
    json_t *item;
    if (!root)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %.100s", path, where.line, where.text);
    json_object_foreach(root, key, item)
    {
        const char *number = json_is_string(item) ? key : NULL, *end = number;
        const int32_t value = number              ? read_value(&end)
                              : json_is_integer(item) && json_integer_value(item) >= 0 &&
                                      json_integer_value(item) <= INT16_MAX
                                  ? (int32_t)json_integer_value(item)
                                  : -1;
        const char *name = number ? json_string_value(item) : key;
        if (value < 0 || (number && *end))
            status = ost_fail(err, OST_ERR_INPUT, "%s: '%.60s'; expected names of labels from 0 to %d, such as "
                              "{\"3\": \"scapula\"} or {\"scapula\": 3}", path, key, INT16_MAX);
        else
            status = add_name(names, value, name, strlen(name), err);
        if (status != OST_OK)
            break;
    }
    json_decref(root);
    return status;
}

/*
 * Parses a line "VALUE NAME ..." or "VALUE,NAME,..." and adds the name to the list. If the line contains strings in
 * double quotes, as in the tables of ITK-SNAP, the last string is the name. Returns false if the line does not begin
 * with a value and a separator, or if the name is empty.
 */
static bool add_line(ost_label_names *names, char *line, ost_status *status, ost_error *err)
{
    const char *p = line + strspn(line, " \t");
    const int32_t value = read_value(&p);
    if (value < 0 || !strchr(" \t,;:=", *p) || !*p)
        return false;
    p += strspn(p, " \t,;:=");
    char *last = strrchr(line, '"'), *first = NULL;
    if (last) {
        *last = 0;
        first = strrchr(line, '"');
    }
    if (first)
        p = first + 1;
    const size_t length = first ? strlen(p) : strcspn(p, " \t,;");
    *status = length ? add_name(names, value, p, length, err) : OST_OK;
    return length > 0;
}

static ost_status add_table(ost_label_names *names, const char *path, char *text, ost_error *err)
{
    ost_status status = OST_OK;
    long number = 1;
    bool has_names = false;
    for (char *line = text, *next; line && status == OST_OK; line = next, number++) {
        next = strchr(line, '\n');
        if (next)
            *next++ = 0;
        line[strcspn(line, "\r")] = 0;
        const char *start = line + strspn(line, " \t");
        if (*start == '#' || !*start || add_line(names, line, &status, err)) {
            has_names = has_names || (*start && *start != '#');
            continue;
        }
        if (has_names || number > 1) /* the first line may be a header with column names */
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: '%.60s'; expected the value and the name of a label, such as "
                            "'3 scapula'", path, number, line);
    }
    if (status == OST_OK && !has_names)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file contains no label names; expected lines such as '3 scapula'",
                        path);
    return status;
}

ost_status ost_label_names_add_file(ost_label_names *names, const char *path, ost_error *err)
{
    char *text;
    size_t size;
    ost_status status =
        ost_small_text_read(path, FILE_MAX, "names", "names of labels as text, CSV or JSON", &text, &size, err);
    if (status == OST_OK)
        status = ost_small_text_is_json(text) ? add_json(names, path, text, size, err)
                                              : add_table(names, path, text, err);
    free(text);
    return status;
}

/* ---------------------------------------------------------------- search */

static ost_status unknown(const ost_label_names *names, const char *mask, const char *name, ost_error *err)
{
    char list[LISTED + OST_LABEL_NAME + 8] = "";
    size_t used = 0;
    int listed = 0;
    /* Lists the existing names. Names whose first ALIKE characters are those of `name`, ignoring case, come first. */
    for (int other = 0; other < 2; other++)
        for (int i = 0; i < names->count && used < LISTED; i++) {
            const ost_label_name *item = &names->items[i];
            if (item->name[0] && item->value >= 0 && (strncasecmp(item->name, name, ALIKE) != 0) == other)
                used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", listed++ ? ", " : "", item->name);
        }
    if (!listed)
        return ost_fail(err, OST_ERR_INPUT, "%s: no label is named '%.60s', because the file has no names; give a "
                        "number, or a file of names with --mask-names", mask, name);
    return ost_fail(err, OST_ERR_INPUT, "%s: no label is named '%.60s'; its labels are %s%s", mask, name, list,
                    used < LISTED ? "" : ", ...");
}

ost_status ost_label_names_find(const ost_label_names *names, const char *mask, const char *name, int16_t *value,
                                ost_error *err)
{
    const ost_label_name *found = NULL;
    for (int i = 0; i < names->count; i++) {
        const ost_label_name *item = &names->items[i];
        if (item->value < 0 || strcasecmp(item->name, name) != 0)
            continue;
        if (found && found->value != item->value)
            return ost_fail(err, OST_ERR_INPUT, "%s: the labels %d and %d are both named '%.60s'; give a number", mask,
                            (int)found->value, (int)item->value, name);
        found = item;
    }
    if (!found)
        return unknown(names, mask, name, err);
    *value = (int16_t)found->value;
    return OST_OK;
}
