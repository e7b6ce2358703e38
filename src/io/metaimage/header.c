/* SPDX-License-Identifier: Apache-2.0 */
#include "io/metaimage/header.h"

#include <stdio.h>
#include <string.h>

#include <osteon/length.h>

#include "io/volume/rows.h"

/* X(identifier, spellings separated by |) for each key that the reader uses. */
#define KEYS(X)                                                      \
    X(OBJECT_TYPE, "ObjectType")                                     \
    X(DIMENSIONS, "NDims")                                           \
    X(SIZES, "DimSize")                                              \
    X(CHANNELS, "ElementNumberOfChannels")                           \
    X(TYPE, "ElementType")                                           \
    X(SPACING, "ElementSpacing")                                     \
    X(ELEMENT_SIZE, "ElementSize")                                   \
    X(UNITS, "DistanceUnits")                                        \
    X(OFFSET, "Offset|Position|Origin")                              \
    X(MATRIX, "TransformMatrix|Rotation|Orientation")                \
    X(BINARY, "BinaryData")                                          \
    X(BIG_ENDIAN, "BinaryDataByteOrderMSB|ElementByteOrderMSB")      \
    X(COMPRESSED, "CompressedData")                                  \
    X(SKIP, "HeaderSize")                                            \
    X(SLOPE, "ElementToIntensityFunctionSlope")                      \
    X(INTERCEPT, "ElementToIntensityFunctionOffset")                 \
    X(DATA, "ElementDataFile")

typedef enum key {
#define KEY_ENUM(name, spellings) KEY_##name,
    KEYS(KEY_ENUM)
#undef KEY_ENUM
    KEY_COUNT
} key;

static const char *const spellings[] = {
#define KEY_ROW(name, text) text,
    KEYS(KEY_ROW)
#undef KEY_ROW
};

typedef struct field {
    char *value; /* value of the field; NULL if the field is absent */
    long line;
} field;

typedef struct reader {
    const char *path;
    ost_header_lines *lines;
    field fields[KEY_COUNT];
    ost_meta *meta;
    ost_error *err;
} reader;

bool ost_metaimage_sniff(const unsigned char *head, size_t size)
{
    static const char *const first[] = {"ObjectType", "NDims", "Comment"};
    for (size_t i = 0; i < sizeof first / sizeof first[0]; i++) {
        const size_t n = strlen(first[i]);
        size_t p = n;
        if (size <= n || memcmp(head, first[i], n) != 0)
            continue;
        while (p < size && (head[p] == ' ' || head[p] == '\t'))
            p++;
        if (p < size && head[p] == '=')
            return true;
    }
    return false;
}

/* ------------------------------------------------------------------- lines */

static key find_key(const char *name, size_t length)
{
    for (int k = 0; k < KEY_COUNT; k++) {
        for (const char *s = spellings[k]; *s;) {
            const size_t n = strcspn(s, "|");
            if (n == length && strncmp(s, name, n) == 0)
                return (key)k;
            s += n + (s[n] == '|');
        }
    }
    return KEY_COUNT;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/*
 * Returns the key of a line, or KEY_COUNT if the reader does not use this key. Sets *length to the length of the
 * key's name. Sets *equals to the '=' of the line, or to NULL if the line has none.
 */
static key key_of(char *line, size_t *length, char **equals)
{
    *equals = strchr(line, '=');
    *length = *equals ? (size_t)(*equals - line) : 0;
    while (*length > 0 && is_blank(line[*length - 1]))
        --*length;
    return find_key(line, *length);
}

/* Stores a header fact. `line` begins with the key, which begins with "osteon_" and has `length` bytes. */
static ost_status take_fact(reader *r, const char *line, size_t length, char *value, long number)
{
    char name[OST_META_KEY];
    snprintf(name, sizeof name, "%.*s", (int)length - 7, line + 7);
    value += 1 + strspn(value + 1, " \t");
    if (length - 7 >= sizeof name)
        return ost_fail(r->err, OST_ERR_INPUT, "%s:%ld: the key of a fact has more than %d bytes", r->path, number,
                        OST_META_KEY - 1);
    const ost_status status = ost_meta_set(r->meta, name, value, r->err);
    return status == OST_OK ? status : ost_fail_context(r->err, "%s:%ld", r->path, number);
}

/* Stores the value of one nonempty line. */
static ost_status take_line(reader *r, char *line, long number)
{
    size_t length;
    char *value;
    const key k = key_of(line, &length, &value);
    if (!value)
        return ost_fail(r->err, OST_ERR_INPUT, "%s:%ld: '%.60s' is not 'Key = Value'", r->path, number, line);
    if (k == KEY_COUNT)
        return length > 7 && strncmp(line, "osteon_", 7) == 0 ? take_fact(r, line, length, value, number) : OST_OK;
    field *f = &r->fields[k];
    if (f->value)
        return ost_fail(r->err, OST_ERR_INPUT, "%s:%ld: duplicate '%.*s'; the first one is in line %ld", r->path,
                        number, (int)length, line, f->line);
    value += 1 + strspn(value + 1, " \t");
    for (size_t n = strlen(value); n > 0 && is_blank(value[n - 1]); n--)
        value[n - 1] = 0;
    *f = (field){value, number};
    return OST_OK;
}

/*
 * Reads the lines up to ElementDataFile. If the value of ElementDataFile is LIST, also reads the file names after it.
 * Sets *count to the number of lines up to and including ElementDataFile.
 */
static ost_status read_lines(reader *r, ost_input *input, size_t *count)
{
    *count = 0;
    for (bool ended = false; !ended;) {
        ost_status status = ost_header_lines_next(r->lines, input, "ElementDataFile", &ended, r->err);
        if (status != OST_OK)
            return status;
        if (ended || *count)
            continue;
        char *equals, *line = ost_header_line(r->lines, r->lines->count - 1);
        size_t length;
        if (key_of(line + strspn(line, " \t"), &length, &equals) != KEY_DATA)
            continue;
        *count = r->lines->count;
        if (!ost_data_is_list(equals + 1 + strspn(equals + 1, " \t")))
            return OST_OK;
    }
    if (*count)
        return OST_OK;
    return ost_fail(r->err, OST_ERR_INPUT, "%s: file ends in the header, at byte %llu; expected ElementDataFile",
                    r->path, (unsigned long long)ost_input_offset(input));
}

/*
 * Splits the lines into fields. Reading a line may move the buffer, so pointers into the lines are stored only after
 * all lines have been read.
 */
static ost_status read_fields(reader *r, ost_input *input, ost_data_names *names)
{
    size_t count;
    ost_status status = read_lines(r, input, &count);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        char *line = ost_header_line(r->lines, i);
        line += strspn(line, " \t");
        if (*line)
            status = take_line(r, line, (long)i + 1);
    }
    if (status != OST_OK)
        return status;
    const field *data = &r->fields[KEY_DATA];
    *names = (ost_data_names){.value = data->value, .line = data->line};
    if (ost_data_is_list(names->value)) {
        /* LIST may be followed by a number of axes with the letter D, as in 2D or 3D; this letter is removed. */
        char *last = data->value + strlen(data->value) - 1;
        if (*last == 'D' && last[-1] >= '1' && last[-1] <= '3')
            *last = 0;
        const size_t at = count < r->lines->count ? r->lines->start[count] : r->lines->size;
        names->list = r->lines->bytes + at;
        names->list_bytes = r->lines->size - at;
    }
    return OST_OK;
}

/* ------------------------------------------------------------------ values */

static const char *value_of(const reader *r, key k)
{
    return r->fields[k].value;
}

/*
 * Returns the error for the value of a key. The message is "file:line: Key = 'value'; ", followed by the text
 * `expected`.
 */
static ost_status wrong(const reader *r, key k, const char *expected)
{
    return ost_fail(r->err, OST_ERR_INPUT, "%s:%ld: %.*s = '%.100s'; %s", r->path, r->fields[k].line,
                    (int)strcspn(spellings[k], "|"), spellings[k], value_of(r, k), expected);
}

static ost_status missing(const reader *r, const char *what)
{
    return ost_fail(r->err, OST_ERR_INPUT, "%s: its header has no '%s ='", r->path, what);
}

/*
 * Reads `count` decimals and multiplies each by its factor. If `factor` is NULL, all factors are 1. Returns false if
 * the value does not consist of `count` decimals. If `exactly` is true, also returns false if a result had to be
 * rounded.
 */
static bool read_decimals(const char *value, int count, const uint64_t *factor, bool exactly, int64_t *out)
{
    const char *p = value, *end = value + strlen(value);
    for (int i = 0; i < count; i++) {
        ost_decimal d;
        bool exact;
        p += strspn(p, " \t");
        p = ost_decimal_read(p, end, &d);
        if (!p || (*p && !is_blank(*p)) || !ost_decimal_scale(&d, factor ? factor[i] : 1, &out[i], &exact) ||
            (exactly && !exact))
            return false;
    }
    return !p[strspn(p, " \t")];
}

static ost_status read_flag(const reader *r, key k, bool absent, bool *out)
{
    const char *value = value_of(r, k);
    *out = absent;
    if (!value)
        return OST_OK;
    *out = *value == 'T' || *value == 't' || *value == '1';
    return *out || *value == 'F' || *value == 'f' || *value == '0' ? OST_OK : wrong(r, k, "expected True or False");
}

static ost_status mean_sizes(const reader *r, ost_metaimage_header *out)
{
    int64_t n, sizes[3];
    const char *value = value_of(r, KEY_OBJECT_TYPE);
    if (value && strcmp(value, "Image") != 0)
        return wrong(r, KEY_OBJECT_TYPE, "expected Image");
    if (!value_of(r, KEY_DIMENSIONS))
        return missing(r, "NDims");
    if (!read_decimals(value_of(r, KEY_DIMENSIONS), 1, NULL, true, &n) || n != 3)
        return wrong(r, KEY_DIMENSIONS, "expected 3");
    value = value_of(r, KEY_CHANNELS);
    if (value && (!read_decimals(value, 1, NULL, true, &n) || n != 1))
        return wrong(r, KEY_CHANNELS, "expected 1, which is one density per voxel");
    if (!value_of(r, KEY_SIZES))
        return missing(r, "DimSize");
    if (!read_decimals(value_of(r, KEY_SIZES), 3, NULL, true, sizes))
        return wrong(r, KEY_SIZES, "expected three whole numbers");
    return ost_rows_sizes(r->path, sizes, out->sizes, r->err);
}

static ost_status mean_elements(const reader *r, ost_metaimage_header *out)
{
    static const struct {
        const char *name;
        ost_element element;
    } types[] = {
        {"MET_CHAR", OST_ELEMENT_INT8},        {"MET_UCHAR", OST_ELEMENT_UINT8},
        {"MET_SHORT", OST_ELEMENT_INT16},      {"MET_USHORT", OST_ELEMENT_UINT16},
        {"MET_INT", OST_ELEMENT_INT32},        {"MET_UINT", OST_ELEMENT_UINT32},
        /* MET_LONG has 4 bytes on every platform */
        {"MET_LONG", OST_ELEMENT_INT32},       {"MET_ULONG", OST_ELEMENT_UINT32},
        {"MET_LONG_LONG", OST_ELEMENT_INT64},  {"MET_ULONG_LONG", OST_ELEMENT_UINT64},
        {"MET_FLOAT", OST_ELEMENT_FLOAT32},    {"MET_DOUBLE", OST_ELEMENT_FLOAT64},
    };
    const char *value = value_of(r, KEY_TYPE);
    if (!value)
        return missing(r, "ElementType");
    size_t t = 0;
    while (t < sizeof types / sizeof types[0] && strcmp(types[t].name, value) != 0)
        t++;
    if (t == sizeof types / sizeof types[0])
        return wrong(r, KEY_TYPE, "expected MET_CHAR, MET_SHORT, MET_INT, MET_LONG, MET_LONG_LONG, one of these with U "
                                  "for unsigned, MET_FLOAT or MET_DOUBLE");
    out->element = types[t].element;

    bool binary, compressed;
    ost_status status = read_flag(r, KEY_BINARY, true, &binary);
    if (status == OST_OK && !binary)
        status = wrong(r, KEY_BINARY, "text data are not supported; save the file again as binary");
    if (status == OST_OK)
        status = read_flag(r, KEY_BIG_ENDIAN, false, &out->swap);
    if (status == OST_OK)
        status = read_flag(r, KEY_COMPRESSED, false, &compressed);
    if (status != OST_OK)
        return status;
    out->form = compressed ? OST_DATA_ZLIB : OST_DATA_RAW;

    static const struct {
        key k;
        int64_t identity;
    } functions[] = {{KEY_SLOPE, 1}, {KEY_INTERCEPT, 0}};
    for (int i = 0; i < 2; i++) {
        int64_t n;
        value = value_of(r, functions[i].k);
        if (value && (!read_decimals(value, 1, NULL, true, &n) || n != functions[i].identity))
            return wrong(r, functions[i].k, "programs disagree on whether this applies to the voxels; save the file "
                                            "again with slope 1 and offset 0");
    }
    return OST_OK;
}

static ost_status mean_skip(const reader *r, ost_metaimage_header *out)
{
    const char *value = value_of(r, KEY_SKIP);
    if (!value)
        return OST_OK;
    if (!read_decimals(value, 1, NULL, true, &out->byte_skip) || out->byte_skip < -1)
        return wrong(r, KEY_SKIP, "expected a number of bytes, or -1 for data at the end of the file");
    if (out->byte_skip != 0 && out->form != OST_DATA_RAW)
        return wrong(r, KEY_SKIP, "expected 0, because the data are compressed");
    if (out->byte_skip > 0 && !out->names.value)
        return wrong(r, KEY_SKIP, "expected 0, because the data follow the header");
    return OST_OK;
}

static bool is_length(ost_pm pm)
{
    return pm <= OST_LENGTH_MAX && pm >= -OST_LENGTH_MAX;
}

static ost_status mean_space(const reader *r, ost_metaimage_header *out)
{
    uint64_t unit = (uint64_t)OST_PM_PER_MM;
    const char *value = value_of(r, KEY_UNITS);
    if (value && strcmp(value, "um") == 0)
        unit /= 1000;
    else if (value && strcmp(value, "cm") == 0)
        unit *= 10;
    else if (value && strcmp(value, "mm") != 0 && strcmp(value, "?") != 0)
        return wrong(r, KEY_UNITS, "expected mm, um or cm");
    const uint64_t units[3] = {unit, unit, unit};

    ost_pm spacing[3];
    const key k = value_of(r, KEY_SPACING) ? KEY_SPACING : KEY_ELEMENT_SIZE;
    if (!value_of(r, k))
        return ost_fail(r->err, OST_ERR_INPUT, "%s: no voxel size in the header; expected 'ElementSpacing ='", r->path);
    if (!read_decimals(value_of(r, k), 3, units, false, spacing))
        return wrong(r, k, "expected three lengths");
    for (int a = 0; a < 3; a++)
        if (spacing[a] <= 0 || !is_length(spacing[a]))
            return wrong(r, k, "expected three lengths greater than 0, within 8 m");

    out->affine = (ost_affine){0};
    value = value_of(r, KEY_MATRIX);
    out->oriented = value;
    if (value) {
        uint64_t factors[9];
        for (int i = 0; i < 9; i++)
            factors[i] = (uint64_t)spacing[i / 3];
        if (!read_decimals(value, 9, factors, false, &out->affine.column[0][0]))
            return wrong(r, KEY_MATRIX, "expected nine numbers: the direction of each axis of the grid");
        for (int i = 0; i < 9; i++)
            if (!is_length(out->affine.column[i / 3][i % 3]))
                return wrong(r, KEY_MATRIX, "expected directions of length 1");
    } else {
        for (int a = 0; a < 3; a++)
            out->affine.column[a][a] = spacing[a];
    }
    value = value_of(r, KEY_OFFSET);
    if (value && !read_decimals(value, 3, units, false, out->affine.origin))
        return wrong(r, KEY_OFFSET, "expected three lengths");
    for (int a = 0; a < 3; a++)
        if (!is_length(out->affine.origin[a]))
            return wrong(r, KEY_OFFSET, "expected three lengths within 8 m");
    return OST_OK;
}

ost_status ost_metaimage_header_read(ost_input *input, ost_metaimage_header *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    reader r = {.path = ost_input_path(input), .lines = &out->lines, .meta = &out->meta, .err = err};
    ost_status status = read_fields(&r, input, &out->names);
    if (status == OST_OK && strcmp(out->names.value, "LOCAL") == 0)
        out->names.value = NULL;
    if (status == OST_OK)
        status = mean_sizes(&r, out);
    if (status == OST_OK)
        status = mean_elements(&r, out);
    if (status == OST_OK)
        status = mean_skip(&r, out);
    if (status == OST_OK)
        status = mean_space(&r, out);
    return status;
}

void ost_metaimage_header_free(ost_metaimage_header *header)
{
    ost_header_lines_free(&header->lines);
}
