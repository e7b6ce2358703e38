/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nifti/extension.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/nifti/header.h"

static const char prefix[] = "osteon ";

static ost_status take_lines(const char *path, char *text, ost_meta *meta, ost_error *err)
{
    for (char *line = text; line && *line;) {
        char *next = strchr(line, '\n');
        if (next)
            *next++ = 0;
        char *colon = strchr(line, ':');
        if (strncmp(line, prefix, sizeof prefix - 1) == 0 && colon && colon[1] == ' ') {
            *colon = 0;
            ost_status status = ost_meta_set(meta, line + sizeof prefix - 1, colon + 2, err);
            if (status != OST_OK) {
                ost_fail_context(err, "%s: comment in the header", path);
                return status;
            }
        }
        line = next;
    }
    return OST_OK;
}

static int32_t read_int32(const unsigned char *b, bool swap)
{
    return swap ? (int32_t)((uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3])
                : (int32_t)((uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | b[0]);
}

ost_status ost_nifti_extensions_read(ost_input *input, uint64_t end, bool swap, ost_meta *meta, ost_label_names *names,
                                     ost_error *err)
{
    unsigned char head[8];
    size_t got;
    if (end < ost_input_offset(input) + 4)
        return OST_OK;
    ost_status status = ost_input_read(input, head, 4, &got, err);
    if (status != OST_OK || got < 4 || head[0] == 0)
        return status;
    while (end - ost_input_offset(input) >= 16) {
        status = ost_input_read(input, head, 8, &got, err);
        if (status != OST_OK || got < 8)
            return status;
        int32_t size = read_int32(head, swap), code = read_int32(head + 4, swap);
        if (size < 16 || (uint64_t)size - 8 > end - ost_input_offset(input))
            return OST_OK;
        size_t bytes = (size_t)size - 8;
        const bool is_comment = code == OST_NIFTI_COMMENT && bytes <= OST_NIFTI_COMMENT_MAX;
        if (!is_comment && !(names && bytes <= OST_NIFTI_NAMES_MAX)) {
            if (bytes > ost_input_at_most(input))
                return OST_OK;
            status = ost_input_skip(input, bytes, err);
        } else {
            char *text = malloc(bytes + 1);
            if (!text)
                return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a comment of %zu bytes",
                                ost_input_path(input), bytes);
            status = ost_input_read(input, text, bytes, &got, err);
            text[status == OST_OK ? got : 0] = 0;
            if (status == OST_OK && names)
                status = ost_label_names_add_xml(names, text, err);
            if (status == OST_OK && is_comment)
                status = take_lines(ost_input_path(input), text, meta, err);
            free(text);
        }
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

/* Appends a formatted line. The caller's buffer must be large enough (see EXTENSION_CAPACITY in write.c). */
static size_t put(unsigned char *out, size_t capacity, size_t used, const char *key, const char *value)
{
    int n = snprintf((char *)out + used, capacity - used, "%s%s: %s\n", prefix, key, value);
    assert(n > 0 && (size_t)n < capacity - used);
    return used + (size_t)n;
}

static size_t put_lengths(unsigned char *out, size_t capacity, size_t used, const char *key, ost_pm3 v)
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT], line[3 * OST_PM_TEXT + 3];
    snprintf(line, sizeof line, "%s %s %s", ost_pm_format(v.x, x), ost_pm_format(v.y, y), ost_pm_format(v.z, z));
    return put(out, capacity, used, key, line);
}

size_t ost_nifti_extension_format(const ost_meta *meta, const ost_geometry *geometry, unsigned char *out,
                                  size_t capacity)
{
    memset(out, 0, capacity);
    out[0] = 1;
    size_t used = 12;
    used = put_lengths(out, capacity, used, OST_NIFTI_SPACING, geometry->spacing);
    used = put_lengths(out, capacity, used, OST_NIFTI_ORIGIN, geometry->origin);
    for (int i = 0; i < meta->count; i++)
        if (!ost_meta_key_is_geometry(meta->entry[i].key))
            used = put(out, capacity, used, meta->entry[i].key, meta->entry[i].value);
    uint32_t size = (uint32_t)((used - 4 + 15) / 16 * 16);
    for (int i = 0; i < 4; i++)
        out[4 + i] = (unsigned char)(size >> 8 * i);
    out[8] = OST_NIFTI_COMMENT;
    return 4 + size;
}
