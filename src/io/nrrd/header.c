/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nrrd/header.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *const spellings[] = {
#define OST_NRRD_FIELD_ROW(name, text) text,
    OST_NRRD_FIELDS(OST_NRRD_FIELD_ROW)
#undef OST_NRRD_FIELD_ROW
};

/* Returns the field of this name, without regard to case, or OST_NRRD_FIELD_COUNT. */
static ost_nrrd_field find_field(const char *name)
{
    size_t length = strlen(name);
    for (int f = 0; f < OST_NRRD_FIELD_COUNT; f++) {
        for (const char *s = spellings[f]; *s;) {
            size_t n = strcspn(s, "|");
            if (n == length && strncasecmp(s, name, n) == 0)
                return (ost_nrrd_field)f;
            s += n + (s[n] == '|');
        }
    }
    return OST_NRRD_FIELD_COUNT;
}

/* ------------------------------------------------------------------ lines */

/* Appends one byte; the buffer doubles up to the limit. */
static ost_status append(ost_nrrd_text *text, size_t *capacity, int byte, const char *path, ost_error *err)
{
    if (text->size == OST_NRRD_HEADER_MAX)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: the header is longer than %d bytes; expected an empty line at its end", path,
                        OST_NRRD_HEADER_MAX);
    if (text->size == *capacity) {
        size_t more = *capacity ? 2 * *capacity : 4096;
        char *bytes = realloc(text->bytes, more);
        if (!bytes)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a header of %zu bytes", path, more);
        text->bytes = bytes;
        *capacity = more;
    }
    text->bytes[text->size++] = (char)byte;
    return OST_OK;
}

/*
 * Appends one line, terminated by NUL. Sets *ended at the end of the file, if no byte precedes it. *start is an
 * offset, because the buffer may be moved.
 */
static ost_status append_line(ost_input *input, ost_nrrd_text *text, size_t *capacity, size_t *start, bool *ended,
                              ost_error *err)
{
    const char *path = ost_input_path(input);
    *start = text->size;
    *ended = false;
    for (;;) {
        int byte;
        ost_status status = ost_input_byte(input, &byte, err);
        if (status != OST_OK)
            return status;
        if (byte < 0 && text->size == *start) {
            *ended = true;
            return OST_OK;
        }
        if (byte == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: a NUL in its header, before byte %llu; expected text", path,
                            (unsigned long long)ost_input_offset(input));
        if (byte < 0 || byte == '\n') {
            if (text->size > *start && text->bytes[text->size - 1] == '\r')
                text->bytes[text->size - 1] = 0;
            return append(text, capacity, 0, path, err);
        }
        status = append(text, capacity, byte, path, err);
        if (status != OST_OK)
            return status;
    }
}

/* ----------------------------------------------------------------- meaning */

/* Undoes the format's escapes "\\" and "\n"; a newline becomes a space, because a value here is one line. */
static void unescape(char *value)
{
    char *to = value;
    for (const char *from = value; *from; from++) {
        if (from[0] == '\\' && (from[1] == '\\' || from[1] == 'n')) {
            *to++ = from[1] == 'n' ? ' ' : '\\';
            from++;
        } else {
            *to++ = *from;
        }
    }
    *to = 0;
}

static ost_status take_line(const char *path, ost_nrrd_text *text, char *line, long number, ost_error *err)
{
    static const char prefix[] = "osteon_";
    if (line[0] == '#')
        return OST_OK;
    char *colon = strchr(line, ':');
    while (colon && colon[1] != ' ' && colon[1] != '\t' && colon[1] != '=' && colon[1] != 0)
        colon = strchr(colon + 1, ':'); /* keys may contain colons */
    if (!colon)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: '%.60s' is neither 'field: value' nor 'key:=value'", path, number,
                        line);
    *colon = 0;
    if (colon[1] == '=') {
        if (strncmp(line, "Segment0_", 9) == 0)
            text->labels = true;
        if (strncmp(line, prefix, sizeof prefix - 1) != 0)
            return OST_OK;
        unescape(colon + 2);
        ost_status status = ost_meta_set(&text->meta, line + sizeof prefix - 1, colon + 2, err);
        if (status != OST_OK)
            ost_fail_context(err, "%s:%ld", path, number);
        return status;
    }
    char *value = colon + 1;
    value += strspn(value, " \t");
    for (size_t n = strlen(value); n > 0 && (value[n - 1] == ' ' || value[n - 1] == '\t'); n--)
        value[n - 1] = 0;
    ost_nrrd_field field = find_field(line);
    if (field == OST_NRRD_FIELD_COUNT)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: '%.60s' is not a field of the NRRD format", path, number, line);
    if (field == OST_NRRD_IGNORED)
        return OST_OK;
    if (text->field[field].value)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: duplicate '%s'; the first one is in line %ld", path, number,
                        line, text->field[field].line);
    text->field[field].value = value;
    text->field[field].line = number;
    return OST_OK;
}

static ost_status check_magic(const char *path, const char *line, ost_error *err)
{
    if (strncmp(line, "NRRD000", 7) != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s:1: '%.20s'; expected NRRD0001 to NRRD0005", path, line);
    if (line[7] < '1' || line[7] > '5' || line[8] != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s:1: unsupported version '%.20s'; expected NRRD0001 to NRRD0005", path,
                        line);
    return OST_OK;
}

static bool starts_list(const char *value)
{
    return value && strncasecmp(value, "LIST", 4) == 0 && (value[4] == 0 || value[4] == ' ' || value[4] == '\t');
}

ost_status ost_nrrd_text_read(ost_input *input, ost_nrrd_text *out, ost_error *err)
{
    const char *path = ost_input_path(input);
    memset(out, 0, sizeof *out);
    size_t capacity = 0, list_start = 0;
    size_t *starts = NULL; /* offsets of the field lines, which are split after the buffer has its final address */
    size_t lines = 0, starts_capacity = 0;
    bool in_list = false, ended;
    ost_status status = OST_OK;
    for (;;) {
        size_t start;
        status = append_line(input, out, &capacity, &start, &ended, err);
        if (status != OST_OK || ended)
            break;
        if (lines == 0 && (status = check_magic(path, out->bytes + start, err)) != OST_OK)
            break;
        if (in_list)
            continue;
        if (out->bytes[start] == 0)
            break;
        if (lines == starts_capacity) {
            size_t more = starts_capacity ? 2 * starts_capacity : 64;
            size_t *bigger = realloc(starts, more * sizeof *starts);
            if (!bigger) {
                status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu header lines", path, more);
                break;
            }
            starts = bigger;
            starts_capacity = more;
        }
        starts[lines++] = start;
        const char *line = out->bytes + start;
        const char *colon = strchr(line, ':');
        if (colon && (strncasecmp(line, "data file:", 10) == 0 || strncasecmp(line, "datafile:", 9) == 0) &&
            starts_list(colon + 1 + strspn(colon + 1, " \t"))) {
            in_list = true;
            list_start = out->size;
            out->list_line = (long)lines + 1;
        }
    }
    if (status == OST_OK && lines == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: file is empty; expected a NRRD header", path);
    for (size_t i = 1; status == OST_OK && i < lines; i++)
        status = take_line(path, out, out->bytes + starts[i], (long)i + 1, err);
    if (status == OST_OK && in_list) {
        out->list = out->bytes + list_start;
        out->list_bytes = out->size - list_start;
    }
    if (status == OST_OK && ended && !out->field[OST_NRRD_DATA_FILE].value)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: file ends in the header, at byte %llu; expected an empty line and the data", path,
                          (unsigned long long)ost_input_offset(input));
    free(starts);
    return status;
}

void ost_nrrd_text_free(ost_nrrd_text *text)
{
    free(text->bytes);
    text->bytes = NULL;
}
