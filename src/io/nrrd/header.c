/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nrrd/header.h"

#include <string.h>
#include <strings.h>

static const char *const spellings[] = {
#define OST_NRRD_FIELD_ROW(name, text) text,
    OST_NRRD_FIELDS(OST_NRRD_FIELD_ROW)
#undef OST_NRRD_FIELD_ROW
};

/* Returns the field with the given name; case is ignored. Returns OST_NRRD_FIELD_COUNT if there is no such field. */
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

/*
 * Replaces the format's escapes: "\\" becomes a backslash, and "\n" becomes a space, because header facts are single
 * lines.
 */
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

static ost_status take_line(const char *path, ost_nrrd_text *text, ost_label_names *names, char *line, long number,
                            ost_error *err)
{
    static const char prefix[] = "osteon_";
    if (line[0] == '#')
        return OST_OK;
    char *colon = strchr(line, ':');
    while (colon && colon[1] != ' ' && colon[1] != '\t' && colon[1] != '=' && colon[1] != 0)
        colon = strchr(colon + 1, ':'); /* a key may contain colons */
    if (!colon)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: '%.60s' is neither 'field: value' nor 'key:=value'", path, number,
                        line);
    *colon = 0;
    if (colon[1] == '=') {
        if (strncmp(line, "Segment0_", 9) == 0)
            text->labels = true;
        if (strncmp(line, prefix, sizeof prefix - 1) != 0) {
            if (!names)
                return OST_OK;
            unescape(colon + 2);
            return ost_label_names_add_segment(names, line, colon + 2, err);
        }
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

/*
 * Reads the lines of the header. If the header contains `data file: LIST`, also reads the file names after the
 * header. Sets *listed to the index of the line with the first file name, or to 0 if there is no list.
 */
static ost_status read_lines(ost_input *input, ost_header_lines *lines, size_t *listed, bool *ended, ost_error *err)
{
    *listed = 0;
    for (;;) {
        ost_status status = ost_header_lines_next(lines, input, "an empty line", ended, err);
        if (status != OST_OK || *ended)
            return status;
        const char *line = ost_header_line(lines, lines->count - 1);
        if (lines->count == 1 && (status = check_magic(ost_input_path(input), line, err)) != OST_OK)
            return status;
        if (*listed)
            continue;
        if (*line == 0)
            return OST_OK;
        const char *colon = strchr(line, ':');
        if (colon && (strncasecmp(line, "data file:", 10) == 0 || strncasecmp(line, "datafile:", 9) == 0) &&
            ost_data_is_list(colon + 1 + strspn(colon + 1, " \t")))
            *listed = lines->count;
    }
}

ost_status ost_nrrd_text_read(ost_input *input, ost_label_names *names, ost_nrrd_text *out, ost_error *err)
{
    const char *path = ost_input_path(input);
    memset(out, 0, sizeof *out);
    size_t listed;
    bool ended;
    ost_status status = read_lines(input, &out->lines, &listed, &ended, err);
    if (status == OST_OK && out->lines.count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: file is empty; expected a NRRD header", path);
    const size_t fields = listed ? listed : out->lines.count - !ended;
    for (size_t i = 1; status == OST_OK && i < fields; i++)
        status = take_line(path, out, names, ost_header_line(&out->lines, i), (long)i + 1, err);
    if (status == OST_OK && listed) {
        out->list_bytes = out->lines.size - (listed < out->lines.count ? out->lines.start[listed] : out->lines.size);
        out->list = out->lines.bytes + out->lines.size - out->list_bytes;
    }
    if (status == OST_OK && ended && !out->field[OST_NRRD_DATA_FILE].value)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: file ends in the header, at byte %llu; expected an empty line and the data", path,
                          (unsigned long long)ost_input_offset(input));
    return status;
}

void ost_nrrd_text_free(ost_nrrd_text *text)
{
    ost_header_lines_free(&text->lines);
}
