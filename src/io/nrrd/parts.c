/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nrrd/parts.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static long value_line(const ost_nrrd_parts *own)
{
    return own->text->field[OST_NRRD_DATA_FILE].line;
}

/* ------------------------------------------------------------------- names */

static ost_status check_name(const ost_nrrd_parts *own, const char *name, ost_error *err)
{
    const char *reason = NULL;
    if (!*name)
        reason = "a file name is empty";
    else if (*name == '/')
        reason = "it is absolute";
    for (const char *p = name; !reason && *p;) {
        size_t n = strcspn(p, "/");
        if (n == 2 && p[0] == '.' && p[1] == '.')
            reason = "it leads upwards";
        p += n + (p[n] == '/');
    }
    if (!reason)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT,
                    "%s:%ld: data file '%.100s': %s; expected a file in the header's folder or below it", own->path,
                    value_line(own), name, reason);
}

/* Joins the header's folder and the name. */
static ost_status join(const ost_nrrd_parts *own, const char *name, char out[OST_NRRD_NAME_MAX], ost_error *err)
{
    ost_status status = check_name(own, name, err);
    if (status != OST_OK)
        return status;
    const char *slash = strrchr(own->path, '/');
    int folder = slash ? (int)(slash - own->path) + 1 : 0;
    int n = snprintf(out, OST_NRRD_NAME_MAX, "%.*s%s", folder, own->path, name);
    if (n < 0 || n >= OST_NRRD_NAME_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.60s...': the name is too long", own->path,
                        value_line(own), name);
    return OST_OK;
}

/*
 * Expands the only conversion of the pattern, %d or %5d or %05d; "%%" stands for
 * "%". The pattern is never passed to printf. Returns the number of conversions, or
 * -1 for any other conversion or if out is too small.
 */
static int expand(const char *pattern, size_t length, int64_t number, char *out, size_t capacity)
{
    int conversions = 0;
    size_t used = 0;
    for (size_t i = 0; i < length && used + 1 < capacity; i++) {
        if (pattern[i] != '%') {
            out[used++] = pattern[i];
            continue;
        }
        if (i + 1 < length && pattern[i + 1] == '%') {
            out[used++] = '%';
            i++;
            continue;
        }
        size_t p = i + 1;
        bool zeros = p < length && pattern[p] == '0';
        int width = 0;
        while (p < length && pattern[p] >= '0' && pattern[p] <= '9' && width < 100)
            width = width * 10 + (pattern[p++] - '0');
        if (p == length || (pattern[p] != 'd' && pattern[p] != 'i' && pattern[p] != 'u') || width > 20)
            return -1;
        int n = snprintf(out + used, capacity - used, zeros ? "%0*lld" : "%*lld", width, (long long)number);
        used += n > 0 ? (size_t)n : 0;
        if (used >= capacity)
            return -1;
        conversions++;
        i = p;
    }
    out[used < capacity ? used : capacity - 1] = 0;
    return conversions;
}

static const char *next_listed(const ost_nrrd_parts *own, const char *at)
{
    const char *end = own->text->list + own->text->list_bytes;
    while (at < end && !*at)
        at++;
    return at < end ? at : NULL;
}

static ost_status name_of(ost_nrrd_parts *own, uint64_t index, char out[OST_NRRD_NAME_MAX], ost_error *err)
{
    char name[OST_NRRD_NAME_MAX];
    if (own->attached) {
        snprintf(out, OST_NRRD_NAME_MAX, "%s", own->path);
        return OST_OK;
    }
    if (own->pattern) {
        if (expand(own->pattern, own->pattern_length, own->first + (int64_t)index * own->step, name, sizeof name) != 1)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.*s': one %%d, with a width at most, was expected",
                            own->path, value_line(own), (int)(own->pattern_length < 100 ? own->pattern_length : 100),
                            own->pattern);
        return join(own, name, out, err);
    }
    if (own->text->list) {
        if (index < own->list_index || !own->list_at) {
            own->list_index = 0;
            own->list_at = next_listed(own, own->text->list);
        }
        while (own->list_index < index) {
            own->list_at = next_listed(own, own->list_at + strlen(own->list_at));
            own->list_index++;
        }
        return join(own, own->list_at, out, err);
    }
    return join(own, own->text->field[OST_NRRD_DATA_FILE].value, out, err);
}

/* -------------------------------------------------------------------- open */

static ost_status skip_lines(ost_input *input, uint64_t lines, ost_error *err)
{
    for (uint64_t done = 0; done < lines;) {
        int byte;
        ost_status status = ost_input_byte(input, &byte, err);
        if (status != OST_OK)
            return status;
        if (byte < 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: ends after %llu of the %llu lines of 'line skip'",
                            ost_input_path(input), (unsigned long long)done, (unsigned long long)lines);
        done += byte == '\n';
    }
    return OST_OK;
}

static ost_status open_part(void *user, uint64_t index, ost_input **out, ost_error *err)
{
    ost_nrrd_parts *own = user;
    const ost_nrrd_header *header = own->header;
    char path[OST_NRRD_NAME_MAX];
    *out = NULL;
    ost_status status = name_of(own, index, path, err);
    if (status == OST_OK)
        status = ost_input_open(path, out, err);
    if (status != OST_OK)
        return status;
    ost_input *input = *out;
    if (own->attached)
        status = ost_input_seek(input, own->attached_at, err);
    if (status == OST_OK)
        status = skip_lines(input, header->line_skip, err);
    if (status == OST_OK && header->byte_skip == -1) {
        uint64_t left = ost_input_file_left(input);
        if (left < own->part_bytes)
            status = ost_fail(err, OST_ERR_INPUT, "%s: has %llu bytes of data, but the header's sizes need %llu",
                              path, (unsigned long long)left, (unsigned long long)own->part_bytes);
        else
            status = ost_input_skip(input, left - own->part_bytes, err);
    } else if (status == OST_OK) {
        if (header->encoding == OST_NRRD_GZIP)
            status = ost_input_gunzip(input, err);
        if (status == OST_OK && header->byte_skip > 0)
            status = ost_input_skip(input, (uint64_t)header->byte_skip, err);
    }
    if (status != OST_OK) {
        ost_input_close(input);
        *out = NULL;
    }
    return status;
}

/* -------------------------------------------------------------------- count */

/* Reads the last `count` words of value as integers. Returns the position of the first of them, or NULL. */
static const char *trailing_numbers(const char *value, int count, int64_t numbers[])
{
    const char *end = value + strlen(value);
    for (int i = count - 1; i >= 0; i--) {
        while (end > value && (end[-1] == ' ' || end[-1] == '\t'))
            end--;
        const char *start = end;
        while (start > value && start[-1] != ' ' && start[-1] != '\t')
            start--;
        ost_decimal d;
        bool exact;
        if (start == value || ost_decimal_read(start, end, &d) != end ||
            !ost_decimal_scale(&d, 1, &numbers[i], &exact) || !exact)
            return NULL;
        end = start;
    }
    while (end > value && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    return end;
}

static ost_status wrong(const ost_nrrd_parts *own, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.100s': %s", own->path, value_line(own),
                    own->text->field[OST_NRRD_DATA_FILE].value, what);
}

/*
 * Reads "name.%d MIN MAX STEP [D]". If the last four words are numbers, the fourth
 * number is D; else there are three numbers and no D.
 */
static ost_status count_numbered(ost_nrrd_parts *own, int64_t *subdimension, bool *numbered, ost_error *err)
{
    const char *value = own->text->field[OST_NRRD_DATA_FILE].value;
    int64_t n[4];
    char probe[OST_NRRD_NAME_MAX];
    *numbered = false;
    const char *end = trailing_numbers(value, 4, n);
    if (end)
        *subdimension = n[3];
    else
        end = trailing_numbers(value, 3, n);
    if (!end || !memchr(value, '%', (size_t)(end - value)))
        return OST_OK;
    int64_t min = n[0], max = n[1], step = n[2];
    const int64_t far = INT64_C(1) << 40;
    if (min < 0 || max < 0 || min > far || max > far || step == 0 || step > far || step < -far ||
        (max - min) / step < 0 || (max != min && (max > min) != (step > 0)))
        return wrong(own, "a first and a last number and a step that leads from one to the other were expected", err);
    *numbered = true;
    own->pattern = value;
    own->pattern_length = (size_t)(end - value);
    own->first = min;
    own->step = step;
    own->count = (uint64_t)((max - min) / step) + 1;
    if (expand(value, own->pattern_length, min, probe, sizeof probe) != 1)
        return wrong(own, "one %d, with a width at most, was expected in the name", err);
    return OST_OK;
}

static ost_status count_listed(ost_nrrd_parts *own, int64_t *subdimension, ost_error *err)
{
    const char *tail = own->text->field[OST_NRRD_DATA_FILE].value + 4;
    tail += strspn(tail, " \t");
    if (*tail) {
        ost_decimal d;
        bool exact;
        if (ost_decimal_read(tail, tail + strlen(tail), &d) != tail + strlen(tail) ||
            !ost_decimal_scale(&d, 1, subdimension, &exact) || !exact)
            return wrong(own, "LIST, with a number of axes at most, was expected", err);
    }
    own->count = 0;
    for (const char *p = next_listed(own, own->text->list); p; p = next_listed(own, p + strlen(p)))
        own->count++;
    if (own->count == 0)
        return wrong(own, "no file names follow the list's header", err);
    return OST_OK;
}

ost_status ost_nrrd_parts_init(ost_nrrd_parts *own, ost_parts *parts, const char *path, const ost_nrrd_text *text,
                               const ost_nrrd_header *header, uint64_t header_end, ost_error *err)
{
    *own = (ost_nrrd_parts){.path = path, .text = text, .header = header, .attached_at = header_end, .count = 1};
    const char *value = text->field[OST_NRRD_DATA_FILE].value;
    int64_t subdimension = 2;
    bool several = false;
    ost_status status = OST_OK;
    own->attached = !value;
    if (value && text->list) {
        several = true;
        status = count_listed(own, &subdimension, err);
    } else if (value) {
        status = count_numbered(own, &subdimension, &several, err);
    }
    if (status != OST_OK)
        return status;

    uint64_t voxels = 1, product = 1;
    for (int a = 0; a < 3; a++) {
        voxels *= (uint64_t)header->sizes[a];
        if (a < subdimension)
            product *= (uint64_t)header->sizes[a];
    }
    uint64_t in_part = voxels;
    if (several) {
        if (subdimension < 1 || subdimension > 3)
            return wrong(own, "a file holds 1, 2 or 3 axes", err);
        if (own->count > OST_NRRD_PARTS_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s:%ld: %llu data files; expected at most %d", path, value_line(own),
                            (unsigned long long)own->count, OST_NRRD_PARTS_MAX);
        if (subdimension < 3 ? own->count != voxels / product : (uint64_t)header->sizes[2] % own->count != 0)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: %llu data files of %lld axes each do not fit sizes %d %d %d",
                            path, value_line(own), (unsigned long long)own->count, (long long)subdimension,
                            header->sizes[0], header->sizes[1], header->sizes[2]);
        in_part = voxels / own->count;
    }
    bool as_text = header->encoding == OST_NRRD_TEXT;
    /* The shortest text of n numbers has one digit per number and one blank between two numbers. */
    own->part_bytes = as_text ? 2 * in_part - 1 : in_part * ost_element_bytes(header->element);
    *parts = (ost_parts){
        .open = open_part, .user = own, .count = own->count, .part_bytes = own->part_bytes, .text = as_text};
    return OST_OK;
}
