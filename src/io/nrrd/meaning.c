/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Interprets the fields of a NRRD header.
 *
 * Lengths are exact decimals in the unit that the header states, or in mm if it states none. They are rounded half
 * to even to picometres. Space coordinates are converted to LPS by changing signs: RAS negates x and y, LAS negates
 * y. Coordinates are used unchanged if the header names no space, or a space that does not refer to a patient, such as
 * 3D-right-handed. If the header has `spacings` but no `space directions`, axis n points along axis n of the space. If
 * the header has no `space origin`, the centre of the first voxel is at 0.
 */
#include "io/nrrd/header.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct meaning {
    const char *path;
    const ost_nrrd_text *text;
    ost_error *err;
} meaning;

static const char *value_of(const meaning *m, ost_nrrd_field field)
{
    return m->text->field[field].value;
}

/*
 * Returns the error for the value of a field. The message is "file:line: 'value': ", followed by the text `expected`.
 */
static ost_status wrong(const meaning *m, ost_nrrd_field field, const char *expected)
{
    return ost_fail(m->err, OST_ERR_INPUT, "%s:%ld: '%.100s': %s", m->path, m->text->field[field].line,
                    value_of(m, field), expected);
}

static ost_status missing(const meaning *m, const char *what)
{
    return ost_fail(m->err, OST_ERR_INPUT, "%s: its header has no '%s:'", m->path, what);
}

static const char *blanks(const char *p)
{
    return p + strspn(p, " \t");
}

/* --------------------------------------------------------- names and numbers */

typedef struct name_value {
    const char *names; /* spellings of the name, separated by | */
    int value;
} name_value;

/* Returns the value of the row that contains `name` as a spelling, ignoring case; -1 if there is no such row. */
static int lookup(const name_value *table, size_t rows, const char *name, size_t length)
{
    for (size_t r = 0; r < rows; r++) {
        for (const char *s = table[r].names; *s;) {
            size_t n = strcspn(s, "|");
            if (n == length && strncasecmp(s, name, n) == 0)
                return table[r].value;
            s += n + (s[n] == '|');
        }
    }
    return -1;
}

#define LOOKUP(table, text) lookup(table, sizeof table / sizeof table[0], text, strlen(text))

/* Reads an integer that ends at a blank or at the end of the text. Returns false if there is no such integer. */
static bool read_integer(const char **p, int64_t *out)
{
    ost_decimal d;
    const char *end = *p + strlen(*p);
    const char *after = ost_decimal_read(*p, end, &d);
    bool exact;
    if (!after || (*after && *after != ' ' && *after != '\t') || !ost_decimal_scale(&d, 1, out, &exact) || !exact)
        return false;
    *p = blanks(after);
    return true;
}

static const name_value types[] = {
    {"signed char|int8|int8_t", OST_ELEMENT_INT8},
    {"uchar|unsigned char|uint8|uint8_t", OST_ELEMENT_UINT8},
    {"short|short int|signed short|signed short int|int16|int16_t", OST_ELEMENT_INT16},
    {"ushort|unsigned short|unsigned short int|uint16|uint16_t", OST_ELEMENT_UINT16},
    {"int|signed int|int32|int32_t", OST_ELEMENT_INT32},
    {"uint|unsigned int|uint32|uint32_t", OST_ELEMENT_UINT32},
    {"longlong|long long|long long int|signed long long|signed long long int|int64|int64_t", OST_ELEMENT_INT64},
    {"ulonglong|unsigned long long|unsigned long long int|uint64|uint64_t", OST_ELEMENT_UINT64},
    {"float", OST_ELEMENT_FLOAT32},
    {"double", OST_ELEMENT_FLOAT64},
};

enum { ENCODING_REFUSED = 100 };
static const name_value encodings[] = {
    {"raw", OST_DATA_RAW},
    {"gzip|gz", OST_DATA_GZIP},
    {"text|txt|ascii", OST_DATA_TEXT},
    {"hex|bzip2|bz2|zrl", ENCODING_REFUSED},
};

static ost_status mean_elements(const meaning *m, ost_nrrd_header *out)
{
    if (!value_of(m, OST_NRRD_TYPE))
        return missing(m, "type");
    int type = LOOKUP(types, value_of(m, OST_NRRD_TYPE));
    if (type < 0)
        return wrong(m, OST_NRRD_TYPE,
                     "not a supported voxel type; expected an integer type of 8 to 64 bits, float or double");
    out->element = (ost_element)type;

    if (!value_of(m, OST_NRRD_ENCODING))
        return missing(m, "encoding");
    int encoding = LOOKUP(encodings, value_of(m, OST_NRRD_ENCODING));
    if (encoding < 0)
        return wrong(m, OST_NRRD_ENCODING, "not an NRRD encoding; expected raw, gzip or text");
    if (encoding == ENCODING_REFUSED)
        return wrong(m, OST_NRRD_ENCODING, "this encoding is not supported; save the file again as raw, gzip or text");
    out->encoding = (ost_data_form)encoding;

    const char *endian = value_of(m, OST_NRRD_ENDIAN);
    if (endian && strcasecmp(endian, "little") != 0 && strcasecmp(endian, "big") != 0)
        return wrong(m, OST_NRRD_ENDIAN, "little or big was expected");
    if (!endian && ost_element_bytes(out->element) > 1 && out->encoding != OST_DATA_TEXT)
        return missing(m, "endian");
    out->swap = endian && strcasecmp(endian, "big") == 0;
    return OST_OK;
}

static ost_status mean_skips(const meaning *m, ost_nrrd_header *out)
{
    int64_t lines = 0;
    const char *p = value_of(m, OST_NRRD_LINE_SKIP);
    if (p && (!read_integer(&p, &lines) || *p || lines < 0))
        return wrong(m, OST_NRRD_LINE_SKIP, "a count of lines was expected");
    out->line_skip = (uint64_t)lines;
    p = value_of(m, OST_NRRD_BYTE_SKIP);
    if (p && (!read_integer(&p, &out->byte_skip) || *p || out->byte_skip < -1))
        return wrong(m, OST_NRRD_BYTE_SKIP, "a count of bytes, or -1 for data at the file's end, was expected");
    if (out->byte_skip == -1 && out->encoding != OST_DATA_RAW)
        return wrong(m, OST_NRRD_BYTE_SKIP, "only raw data can be counted from the file's end");
    return OST_OK;
}

/* ------------------------------------------------------------------- sizes */

static ost_status mean_sizes(const meaning *m, ost_nrrd_header *out)
{
    int64_t dimension, sizes[3];
    const char *p = value_of(m, OST_NRRD_DIMENSION);
    if (!p)
        return missing(m, "dimension");
    if (!read_integer(&p, &dimension) || *p || dimension < 1)
        return wrong(m, OST_NRRD_DIMENSION, "a count of axes was expected");
    const char *kinds = value_of(m, OST_NRRD_KINDS);
    if (dimension == 4 && m->text->labels)
        return ost_fail(m->err, OST_ERR_INPUT,
                        "%s:%ld: a segmentation in layers, because segments overlap; in 3D Slicer, export it as a "
                        "binary label map (module Segmentations, Export) and use this file", m->path,
                        m->text->field[OST_NRRD_DIMENSION].line);
    if (dimension != 3)
        return ost_fail(m->err, OST_ERR_INPUT,
                        "%s:%ld: %lld axes%s%.60s%s; expected three, with one density per voxel", m->path,
                        m->text->field[OST_NRRD_DIMENSION].line, (long long)dimension, kinds ? " (" : "",
                        kinds ? kinds : "", kinds ? ")" : "");
    p = value_of(m, OST_NRRD_SIZES);
    if (!p)
        return missing(m, "sizes");
    for (int a = 0; a < 3; a++)
        if (!read_integer(&p, &sizes[a]))
            return wrong(m, OST_NRRD_SIZES, "expected three whole numbers");
    if (*p)
        return wrong(m, OST_NRRD_SIZES, "expected three whole numbers, since there are three axes");
    for (int a = 0; a < 3; a++) {
        if (sizes[a] < 1)
            return wrong(m, OST_NRRD_SIZES, "every size must be at least 1");
        if (sizes[a] > OST_DIM_MAX)
            return ost_fail(m->err, OST_ERR_RANGE, "%s:%ld: %lld voxels along an axis; expected at most %d", m->path,
                            m->text->field[OST_NRRD_SIZES].line, (long long)sizes[a], OST_DIM_MAX);
        out->sizes[a] = (int32_t)sizes[a];
    }
    if (sizes[0] * sizes[1] * sizes[2] > INT64_C(1) << 36)
        return ost_fail(m->err, OST_ERR_RANGE, "%s:%ld: %lld x %lld x %lld voxels; expected at most 2^36 in all",
                        m->path, m->text->field[OST_NRRD_SIZES].line, (long long)sizes[0], (long long)sizes[1],
                        (long long)sizes[2]);

    static const name_value plain[] = {{"domain|space|none|?|???", 1}};
    p = kinds;
    for (int a = 0; p && a < 3; a++) {
        size_t n = strcspn(p, " \t");
        if (n == 0)
            return wrong(m, OST_NRRD_KINDS, "expected three kinds");
        if (lookup(plain, 1, p, n) < 0)
            return wrong(m, OST_NRRD_KINDS,
                         "expected three axes of space (domain or space), not vectors, colours or time");
        p = blanks(p + n);
    }
    if (p && *p)
        return wrong(m, OST_NRRD_KINDS, "expected three kinds");
    return OST_OK;
}

/* ------------------------------------------------------------------- units */

/* Returns the unit of length with the given name, in picometres. Returns 0 if the name is unknown. */
static uint64_t unit_of(const char *name, size_t length)
{
    static const name_value units[] = {
        {"mm|millimeter|millimeters|millimetre|millimetres", 9},
        {"um|\xc2\xb5m|\xce\xbcm|micron|microns|micrometer|micrometers|micrometre|micrometres", 6},
        {"cm|centimeter|centimeters|centimetre|centimetres", 10},
        {"m|meter|meters|metre|metres", 12},
        {"nm|nanometer|nanometers|nanometre|nanometres", 3},
    };
    if (length == 0)
        return (uint64_t)OST_PM_PER_MM;
    int power = lookup(units, sizeof units / sizeof units[0], name, length);
    uint64_t pm = power < 0 ? 0 : 1;
    for (int i = 0; i < power; i++)
        pm *= 10;
    return pm;
}

/* Reads three quoted names of units. If the field is absent, all three units are mm. */
static ost_status mean_units(const meaning *m, ost_nrrd_field field, uint64_t out[3])
{
    const char *p = value_of(m, field);
    for (int a = 0; a < 3; a++) {
        out[a] = (uint64_t)OST_PM_PER_MM;
        if (!p)
            continue;
        const char *close = *p == '"' ? strchr(p + 1, '"') : NULL;
        if (!close)
            return wrong(m, field, "expected three units in double quotes, for example \"mm\" \"mm\" \"mm\"");
        out[a] = unit_of(p + 1, (size_t)(close - p - 1));
        if (out[a] == 0)
            return wrong(m, field, "unknown unit; expected mm, um, nm, cm or m");
        p = blanks(close + 1);
    }
    if (p && *p)
        return wrong(m, field, "expected three units");
    return OST_OK;
}

/* ------------------------------------------------------------------- space */

/* Reads one length that is given in units of `unit` pm. */
static bool read_length(const char **p, uint64_t unit, ost_pm *out)
{
    ost_decimal d;
    const char *after = ost_decimal_read(*p, *p + strlen(*p), &d);
    if (!after || !ost_decimal_scale(&d, unit, out, NULL) || *out > OST_LENGTH_MAX || *out < -OST_LENGTH_MAX)
        return false;
    *p = blanks(after);
    return true;
}

/* Reads a vector "(a,b,c)". */
static bool read_vector(const char **p, const uint64_t unit[3], ost_pm out[3])
{
    if (**p != '(')
        return false;
    *p = blanks(*p + 1);
    for (int w = 0; w < 3; w++) {
        if (!read_length(p, unit[w], &out[w]) || **p != (w < 2 ? ',' : ')'))
            return false;
        *p = blanks(*p + 1);
    }
    return true;
}

/* Kinds of space. The kind determines which coordinates change sign in the conversion to LPS. */
typedef enum space_kind { SPACE_UNSPECIFIED, SPACE_LPS, SPACE_RAS, SPACE_LAS, SPACE_TIME } space_kind;

static const name_value spaces[] = {
    {"left-posterior-superior|LPS", SPACE_LPS},
    {"right-anterior-superior|RAS", SPACE_RAS},
    {"left-anterior-superior|LAS", SPACE_LAS},
    {"scanner-xyz|3D-right-handed|3D-left-handed", SPACE_UNSPECIFIED},
    {"left-posterior-superior-time|LPST|right-anterior-superior-time|RAST|left-anterior-superior-time|LAST|scanner-xyz-"
     "time|"
     "3D-right-handed-time|3D-left-handed-time",
     SPACE_TIME},
};

static ost_status mean_directions(const meaning *m, const uint64_t space_units[3], ost_nrrd_header *out)
{
    const char *p = value_of(m, OST_NRRD_SPACE_DIRECTIONS);
    for (int a = 0; a < 3; a++)
        if (!read_vector(&p, space_units, out->affine.column[a]))
            return wrong(m, OST_NRRD_SPACE_DIRECTIONS,
                         "expected three vectors (x,y,z) with components from -8000 to 8000 mm");
    return *p ? wrong(m, OST_NRRD_SPACE_DIRECTIONS, "expected three vectors, since there are three axes") : OST_OK;
}

static ost_status mean_spacings(const meaning *m, const uint64_t units[3], ost_nrrd_header *out)
{
    const char *p = value_of(m, OST_NRRD_SPACINGS);
    for (int a = 0; a < 3; a++) {
        ost_pm *spacing = &out->affine.column[a][a];
        if (!read_length(&p, units[a], spacing) || *spacing <= 0)
            return wrong(m, OST_NRRD_SPACINGS, "expected three lengths greater than 0, up to 8000 mm");
    }
    return *p ? wrong(m, OST_NRRD_SPACINGS, "expected three lengths, since there are three axes") : OST_OK;
}

/*
 * Returns true if the field `spacings` contains a spacing. The value nan for every axis means that no spacing is
 * given.
 */
static bool has_spacings(const meaning *m)
{
    const char *p = value_of(m, OST_NRRD_SPACINGS);
    if (!p)
        return false;
    while (strncasecmp(p, "nan", 3) == 0 && (p[3] == 0 || p[3] == ' ' || p[3] == '\t'))
        p = blanks(p + 3);
    return *p != 0;
}

static ost_status mean_space(const meaning *m, ost_nrrd_header *out)
{
    int space = SPACE_UNSPECIFIED;
    const char *name = value_of(m, OST_NRRD_SPACE), *p = value_of(m, OST_NRRD_SPACE_DIMENSION);
    int64_t dimension;
    if (name && (space = LOOKUP(spaces, name)) < 0)
        return wrong(m, OST_NRRD_SPACE, "unknown space; expected left-posterior-superior (LPS), "
                     "right-anterior-superior (RAS), left-anterior-superior (LAS), scanner-xyz, 3D-right-handed or "
                     "3D-left-handed");
    if (space == SPACE_TIME)
        return wrong(m, OST_NRRD_SPACE, "a space with time; a CT has three axes of space");
    if (name && p)
        return wrong(m, OST_NRRD_SPACE_DIMENSION, "given beside 'space', which has its dimension already");
    if (p && (!read_integer(&p, &dimension) || *p || dimension != 3))
        return wrong(m, OST_NRRD_SPACE_DIMENSION, "3 was expected");
    bool has_space = name || value_of(m, OST_NRRD_SPACE_DIMENSION);
    static const ost_nrrd_field needs[] = {OST_NRRD_SPACE_DIRECTIONS, OST_NRRD_SPACE_ORIGIN, OST_NRRD_SPACE_UNITS};
    for (size_t i = 0; i < 3; i++)
        if (value_of(m, needs[i]) && !has_space)
            return wrong(m, needs[i],
                         "a vector without a space; expected the field 'space' or 'space dimension' before the data");

    uint64_t units[3], space_units[3];
    ost_status status = mean_units(m, OST_NRRD_SPACE_UNITS, space_units);
    if (status == OST_OK)
        status = mean_units(m, value_of(m, OST_NRRD_UNITS) ? OST_NRRD_UNITS : OST_NRRD_SPACE_UNITS, units);
    if (status != OST_OK)
        return status;

    bool directions = value_of(m, OST_NRRD_SPACE_DIRECTIONS);
    if (directions && has_spacings(m))
        return wrong(m, OST_NRRD_SPACINGS, "given beside 'space directions', which have the spacing already");
    if (!directions && !has_spacings(m))
        return ost_fail(m->err, OST_ERR_INPUT,
                        "%s: no voxel size in the header; expected 'spacings:' or 'space directions:'", m->path);
    status = directions ? mean_directions(m, space_units, out) : mean_spacings(m, units, out);
    if (status != OST_OK)
        return status;
    p = value_of(m, OST_NRRD_SPACE_ORIGIN);
    if (p && (!read_vector(&p, space_units, out->affine.origin) || *p))
        return wrong(m, OST_NRRD_SPACE_ORIGIN, "expected one vector (x,y,z) with components from -8000 to 8000 mm");

    const bool turn[3] = {space == SPACE_RAS, space == SPACE_RAS || space == SPACE_LAS, false};
    for (int w = 0; w < 3; w++) {
        if (!turn[w])
            continue;
        out->affine.origin[w] = -out->affine.origin[w];
        for (int a = 0; a < 3; a++)
            out->affine.column[a][w] = -out->affine.column[a][w];
    }
    out->oriented = space != SPACE_UNSPECIFIED;
    return OST_OK;
}

ost_status ost_nrrd_header_mean(const char *path, const ost_nrrd_text *text, ost_nrrd_header *out, ost_error *err)
{
    const meaning m = {path, text, err};
    memset(out, 0, sizeof *out);
    ost_status status = mean_sizes(&m, out);
    if (status == OST_OK)
        status = mean_elements(&m, out);
    if (status == OST_OK)
        status = mean_skips(&m, out);
    if (status == OST_OK)
        status = mean_space(&m, out);
    return status;
}
