/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/data_files.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <osteon/length.h>

#include "core/file.h"

/* ------------------------------------------------------------------- names */

static ost_status check_name(const ost_data_files *files, const char *name, ost_error *err)
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
                    "%s:%ld: data file '%.100s': %s; expected a file in the header's folder or below it", files->path,
                    files->names.line, name, reason);
}

/* Appends a file name to the folder of the header. */
static ost_status join(const ost_data_files *files, const char *name, char out[OST_DATA_NAME_MAX], ost_error *err)
{
    ost_status status = check_name(files, name, err);
    if (status == OST_OK && ost_file_is_stream(files->path))
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s:%ld: data file '%.100s': a header from a pipe has no folder; its data must follow it",
                          files->path, files->names.line, name);
    if (status != OST_OK)
        return status;
    const char *slash = strrchr(files->path, '/');
    int folder = slash ? (int)(slash - files->path) + 1 : 0;
    int n = snprintf(out, OST_DATA_NAME_MAX, "%.*s%s", folder, files->path, name);
    if (n < 0 || n >= OST_DATA_NAME_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.60s...': the name is too long", files->path,
                        files->names.line, name);
    return OST_OK;
}

/*
 * Expands the pattern of a file name. Conversions of the form %d, %5d or %05d are supported, and "%%" yields "%". The
 * pattern is never passed to printf. Returns the number of conversions; a valid pattern has one. Returns -1 if a
 * conversion has another form or `out` is too small.
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

static const char *next_listed(const ost_data_files *files, const char *at)
{
    const char *end = files->names.list + files->names.list_bytes;
    while (at < end && !*at)
        at++;
    return at < end ? at : NULL;
}

static ost_status name_of(ost_data_files *files, uint64_t index, char out[OST_DATA_NAME_MAX], ost_error *err)
{
    char name[OST_DATA_NAME_MAX];
    if (!files->names.value) {
        snprintf(out, OST_DATA_NAME_MAX, "%s", files->path);
        return OST_OK;
    }
    if (files->pattern) {
        const int64_t number = files->first + (int64_t)index * files->step;
        const int shown = files->pattern_length < 100 ? (int)files->pattern_length : 100;
        if (expand(files->pattern, files->pattern_length, number, name, sizeof name) != 1)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.*s': one %%d, with a width at most, was expected",
                            files->path, files->names.line, shown, files->pattern);
        return join(files, name, out, err);
    }
    if (files->names.list) {
        if (index < files->list_index || !files->list_at) {
            files->list_index = 0;
            files->list_at = next_listed(files, files->names.list);
        }
        while (files->list_index < index) {
            files->list_at = next_listed(files, files->list_at + strlen(files->list_at));
            files->list_index++;
        }
        return join(files, files->list_at, out, err);
    }
    return join(files, files->names.value, out, err);
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
    ost_data_files *files = user;
    char path[OST_DATA_NAME_MAX];
    *out = NULL;
    ost_status status = name_of(files, index, path, err);
    if (status == OST_OK)
        status = ost_input_open(path, out, err);
    if (status != OST_OK)
        return status;
    ost_input *input = *out;
    if (!files->names.value)
        status = ost_input_seek(input, files->attached_at, err);
    if (status == OST_OK)
        status = skip_lines(input, files->line_skip, err);
    if (status == OST_OK && files->byte_skip == -1) {
        uint64_t left = ost_input_file_left(input);
        if (left < files->part_bytes)
            status = ost_fail(err, OST_ERR_INPUT, "%s: has %llu bytes of data, but the header's sizes need %llu",
                              path, (unsigned long long)left, (unsigned long long)files->part_bytes);
        else
            status = ost_input_skip(input, left - files->part_bytes, err);
    } else if (status == OST_OK) {
        if (files->form == OST_DATA_GZIP)
            status = ost_input_gunzip(input, err);
        else if (files->form == OST_DATA_ZLIB)
            status = ost_input_inflate(input, err);
        if (status == OST_OK && files->byte_skip > 0)
            status = ost_input_skip(input, (uint64_t)files->byte_skip, err);
    }
    if (status != OST_OK) {
        ost_input_close(input);
        *out = NULL;
    }
    return status;
}

/* -------------------------------------------------------------------- count */

/*
 * Reads the last `count` words of `value` as integers. Returns the start of the first of these words, or NULL if there
 * are not enough words or one is not an integer.
 */
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

static ost_status wrong(const ost_data_files *files, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s:%ld: data file '%.100s': %s", files->path, files->names.line,
                    files->names.value, what);
}

/* Reads "name.%d MIN MAX STEP [D]". D is present if the last four words are numbers. */
static ost_status count_numbered(ost_data_files *files, int64_t *subdimension, bool *numbered, ost_error *err)
{
    const char *value = files->names.value;
    int64_t n[4];
    char probe[OST_DATA_NAME_MAX];
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
        return wrong(files, "a first and a last number and a step that leads from one to the other were expected", err);
    *numbered = true;
    files->pattern = value;
    files->pattern_length = (size_t)(end - value);
    files->first = min;
    files->step = step;
    files->count = (uint64_t)((max - min) / step) + 1;
    if (expand(value, files->pattern_length, min, probe, sizeof probe) != 1)
        return wrong(files, "one %d, with a width at most, was expected in the name", err);
    return OST_OK;
}

static ost_status count_listed(ost_data_files *files, int64_t *subdimension, ost_error *err)
{
    const char *tail = files->names.value + 4;
    tail += strspn(tail, " \t");
    if (*tail) {
        ost_decimal d;
        bool exact;
        if (ost_decimal_read(tail, tail + strlen(tail), &d) != tail + strlen(tail) ||
            !ost_decimal_scale(&d, 1, subdimension, &exact) || !exact)
            return wrong(files, "LIST, with a number of axes at most, was expected", err);
    }
    files->count = 0;
    for (const char *p = next_listed(files, files->names.list); p; p = next_listed(files, p + strlen(p)))
        files->count++;
    if (files->count == 0)
        return wrong(files, "no file names follow the list's header", err);
    return OST_OK;
}

bool ost_data_is_list(const char *value)
{
    return value && strncasecmp(value, "LIST", 4) == 0 && (value[4] == 0 || value[4] == ' ' || value[4] == '\t');
}

ost_status ost_data_files_open(ost_data_files *files, ost_parts *parts, ost_error *err)
{
    int64_t subdimension = 2;
    bool several = false;
    ost_status status = OST_OK;
    files->count = 1;
    if (files->names.list) {
        several = true;
        status = count_listed(files, &subdimension, err);
    } else if (files->names.value) {
        status = count_numbered(files, &subdimension, &several, err);
    }
    if (status != OST_OK)
        return status;

    uint64_t voxels = 1, product = 1;
    for (int a = 0; a < 3; a++) {
        voxels *= (uint64_t)files->sizes[a];
        if (a < subdimension)
            product *= (uint64_t)files->sizes[a];
    }
    uint64_t in_part = voxels;
    if (several) {
        if (subdimension < 1 || subdimension > 3)
            return wrong(files, "a file holds 1, 2 or 3 axes", err);
        if (files->count > OST_DATA_FILES_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s:%ld: %llu data files; expected at most %d", files->path,
                            files->names.line, (unsigned long long)files->count, OST_DATA_FILES_MAX);
        if (subdimension < 3 ? files->count != voxels / product : (uint64_t)files->sizes[2] % files->count != 0)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: %llu data files of %lld axes each do not fit sizes %d %d %d",
                            files->path, files->names.line, (unsigned long long)files->count, (long long)subdimension,
                            files->sizes[0], files->sizes[1], files->sizes[2]);
        in_part = voxels / files->count;
    }
    bool as_text = files->form == OST_DATA_TEXT;
    /* n numbers as text need at least n digits and n - 1 blanks */
    files->part_bytes = as_text ? 2 * in_part - 1 : in_part * files->element_bytes;
    *parts = (ost_parts){
        .open = open_part, .user = files, .count = files->count, .part_bytes = files->part_bytes, .text = as_text};
    return OST_OK;
}
