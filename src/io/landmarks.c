/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads landmarks from files.
 *
 *   .mrk.json   3D Slicer 4.11 and later: the control points of every markup; its
 *               coordinateSystem is LPS (the schema's default) or RAS
 *   .fcsv       earlier versions of 3D Slicer: "# CoordinateSystem = LPS|RAS|0|1", "# columns = ..."
 *   CSV         label,x,y,z in LPS. A header line or "# columns" names other
 *               columns, including l,p,s and r,a,s; the comment
 *               "# CoordinateSystem" selects another coordinate system
 *
 * Labels are matched to roles without regard to case, blanks, '-' and '_'.  A
 * file has at most FILE_MAX bytes; every coordinate is from -8 m to 8 m.
 */
#include "core/conditions.h"

#include <osteon/io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <jansson.h>

#include "io/small_text.h"

enum { FILE_MAX = 4 << 20, LANDMARKS_MAX = 10000, COLUMNS_MAX = 32 };

/* ------------------------------------------------------------------ labels */

static const struct {
    const char *name; /* label in lower case, without blanks, '-' and '_' */
    ost_landmark_role role;
} names[] = {
    {"glenoid", OST_LANDMARK_GLENOID},
    {"glenoidcentre", OST_LANDMARK_GLENOID},
    {"glenoidcenter", OST_LANDMARK_GLENOID},
    {"gc", OST_LANDMARK_GLENOID},
    {"axis", OST_LANDMARK_AXIS_POINT},
    {"axispoint", OST_LANDMARK_AXIS_POINT},
    {"glenoidaxis", OST_LANDMARK_AXIS_POINT},
    {"trigonum", OST_LANDMARK_TRIGONUM},
    {"trigonumspinae", OST_LANDMARK_TRIGONUM},
    {"trigonumscapulae", OST_LANDMARK_TRIGONUM},
    {"rootofspine", OST_LANDMARK_TRIGONUM},
    {"spineroot", OST_LANDMARK_TRIGONUM},
    {"ts", OST_LANDMARK_TRIGONUM},
    {"inferiorangle", OST_LANDMARK_INFERIOR_ANGLE},
    {"angulusinferior", OST_LANDMARK_INFERIOR_ANGLE},
    {"ai", OST_LANDMARK_INFERIOR_ANGLE},
    {"ia", OST_LANDMARK_INFERIOR_ANGLE},
};

ost_landmark_role ost_landmark_role_of(const char *label)
{
    char text[24];
    size_t n = 0;
    for (; *label; label++) {
        if (strchr(" -_", *label))
            continue;
        if (n + 1 == sizeof text)
            return OST_LANDMARK_OTHER;
        text[n++] = (char)(*label >= 'A' && *label <= 'Z' ? *label - 'A' + 'a' : *label);
    }
    text[n] = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(text, names[i].name) == 0)
            return names[i].role;
    return OST_LANDMARK_OTHER;
}

/* ----------------------------------------------------------------- the list */

static ost_status add(const char *location, ost_landmarks *all, const char *label, size_t length, ost_pm3 at, bool ras,
                      ost_error *err)
{
    if (all->count == LANDMARKS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: more than %d landmarks", location, LANDMARKS_MAX);
    if (all->count % 64 == 0) {
        ost_landmark *items = realloc(all->items, ((size_t)all->count + 64) * sizeof *items);
        if (!items)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %d landmarks", location, all->count + 64);
        all->items = items;
    }
    ost_landmark *l = &all->items[all->count];
    *l = (ost_landmark){.at = {ras ? -at.x : at.x, ras ? -at.y : at.y, at.z}};
    for (size_t i = 0, n = 0; i < length && n + 1 < sizeof l->label; i++)
        l->label[n++] = (unsigned char)label[i] < 0x20 || label[i] == 0x7f ? '?' : label[i];
    l->role = ost_landmark_role_of(l->label);
    for (int i = 0; i < all->count && l->role != OST_LANDMARK_OTHER; i++)
        if (all->items[i].role == l->role)
            return strcmp(all->items[i].label, l->label) == 0
                       ? ost_fail(err, OST_ERR_INPUT, "%s: the landmark '%s' is given twice; expected one position",
                                  location, l->label)
                       : ost_fail(err, OST_ERR_INPUT, "%s: '%s' and '%s' name the same landmark; expected one position",
                                  location, all->items[i].label, l->label);
    all->count++;
    return OST_OK;
}

void ost_landmarks_free(ost_landmarks *landmarks)
{
    free(landmarks->items);
    *landmarks = (ost_landmarks){0};
}

/* -------------------------------------------------------------------- JSON */

static ost_status json_ras(const char *path, const json_t *markup, bool *ras, ost_error *err)
{
    const char *system = json_string_value(json_object_get(markup, "coordinateSystem"));
    const char *units = json_string_value(json_object_get(markup, "coordinateUnits"));
    *ras = system && (strcasecmp(system, "RAS") == 0 || strcmp(system, "0") == 0);
    if (system && !*ras && strcasecmp(system, "LPS") != 0 && strcmp(system, "1") != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: coordinateSystem is '%.20s'; expected LPS or RAS", path, system);
    if (units && strcmp(units, "mm") != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: coordinateUnits is '%.20s'; expected mm", path, units);
    return OST_OK;
}

static ost_status json_point(const char *path, const json_t *point, size_t number, bool ras, ost_landmarks *out,
                             ost_error *err)
{
    const json_t *position = json_object_get(point, "position"), *label = json_object_get(point, "label");
    const char *defined = json_string_value(json_object_get(point, "positionStatus"));
    ost_pm p[3];
    char location[300];
    /* 3D Slicer also writes points that have not been placed yet. Such points are skipped. */
    if ((defined && strcmp(defined, "defined") != 0) || json_is_null(position))
        return OST_OK;
    snprintf(location, sizeof location, "%.240s: control point %zu", path, number);
    if (json_array_size(position) != 3)
        return ost_fail(err, OST_ERR_INPUT, "%s: the position is not an array of three numbers", location);
    for (size_t a = 0; a < 3; a++) {
        const json_t *value = json_array_get(position, a);
        if (!json_is_number(value) || !ost_pm_from_double(json_number_value(value), &p[a]))
            return ost_fail(err, OST_ERR_INPUT, "%s: coordinate %zu of the position is not a length within 8 m",
                            location, a + 1);
    }
    return add(location, out, json_is_string(label) ? json_string_value(label) : "", json_string_length(label),
               (ost_pm3){p[0], p[1], p[2]}, ras, err);
}

static ost_status read_json(const char *path, const char *text, size_t size, ost_landmarks *out, ost_error *err)
{
    json_error_t where;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %.100s", path, where.line, where.text);
    const json_t *markups = json_object_get(root, "markups");
    ost_status status = OST_OK;
    if (!json_is_array(markups))
        status = ost_fail(err, OST_ERR_INPUT, "%s: no array 'markups'; expected a .mrk.json of 3D Slicer", path);
    for (size_t m = 0; m < json_array_size(markups) && status == OST_OK; m++) {
        const json_t *markup = json_array_get(markups, m), *points = json_object_get(markup, "controlPoints");
        bool ras = false;
        status = json_ras(path, markup, &ras, err);
        for (size_t i = 0; i < json_array_size(points) && status == OST_OK; i++)
            status = json_point(path, json_array_get(points, i), i + 1, ras, out, err);
    }
    json_decref(root);
    return status;
}

/* --------------------------------------------------------------------- CSV */

/* Indices of the fields that contain the label and the coordinates; -1 if no field contains the value. */
typedef struct columns {
    int label, x, y, z;
} columns;

typedef struct table {
    const char *path;
    long line;
    bool fcsv, has_system, ras, has_columns;
    columns columns;
} table;

typedef struct field {
    const char *begin;
    size_t length;
} field;

/*
 * Splits a line into its fields at the commas. A field in double quotes may
 * contain commas. Returns the number of fields, at most COLUMNS_MAX.
 */
static int split(const char *p, const char *end, field *out)
{
    int count = 0;
    for (;;) {
        while (p < end && (*p == ' ' || *p == '\t'))
            p++;
        const bool quoted = p < end && *p == '"';
        const char *from = quoted ? p + 1 : p, *to = from;
        while (to < end && *to != (quoted ? '"' : ','))
            to++;
        p = to;
        while (p < end && *p != ',')
            p++;
        while (!quoted && to > from && (to[-1] == ' ' || to[-1] == '\t'))
            to--;
        out[count++] = (field){from, (size_t)(to - from)};
        if (p == end || count == COLUMNS_MAX)
            return count;
        p++;
    }
}

static bool is_word(const field *f, const char *word)
{
    return strlen(word) == f->length && strncasecmp(f->begin, word, f->length) == 0;
}

/* Reads the fields as column names. Returns true if they include a label and the three coordinates of a position. */
static bool take_columns(table *t, const field *fields, int count)
{
    static const char *const triples[][3] = {
        {"x", "y", "z"}, {"x_mm", "y_mm", "z_mm"}, {"l", "p", "s"}, {"r", "a", "s"}};
    columns c = {-1, -1, -1, -1};
    for (size_t k = 0; k < sizeof triples / sizeof triples[0]; k++) {
        int at[3] = {-1, -1, -1};
        for (int i = 0; i < count; i++)
            for (int a = 0; a < 3; a++)
                at[a] = is_word(&fields[i], triples[k][a]) ? i : at[a];
        if (at[0] < 0 || at[1] < 0 || at[2] < 0)
            continue;
        c = (columns){-1, at[0], at[1], at[2]};
        if (k >= 2) {
            t->has_system = true;
            t->ras = k == 3;
        }
    }
    for (int i = 0; i < count; i++)
        c.label = is_word(&fields[i], "label") || (c.label < 0 && is_word(&fields[i], "name")) ? i : c.label;
    if (c.x < 0 || c.label < 0)
        return false;
    t->columns = c;
    t->has_columns = true;
    return true;
}

/* Reads a comment: "# CoordinateSystem = LPS" or "# columns = id,x,y,z,...". Other comments are ignored. */
static ost_status take_comment(table *t, const char *p, const char *end, ost_error *err)
{
    p++;
    while (p < end && (*p == ' ' || *p == '\t'))
        p++;
    const char *equals = memchr(p, '=', (size_t)(end - p));
    if (!equals)
        return OST_OK;
    const char *key_end = equals;
    while (key_end > p && (key_end[-1] == ' ' || key_end[-1] == '\t'))
        key_end--;
    const field key = {p, (size_t)(key_end - p)};
    field values[COLUMNS_MAX];
    const int count = split(equals + 1, end, values);
    if (is_word(&key, "CoordinateSystem")) {
        t->ras = is_word(&values[0], "RAS") || is_word(&values[0], "0");
        if (!t->ras && !is_word(&values[0], "LPS") && !is_word(&values[0], "1"))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: CoordinateSystem is '%.*s'; expected LPS or RAS", t->path,
                            t->line, (int)(values[0].length < 20 ? values[0].length : 20), values[0].begin);
        t->has_system = true;
    } else if (is_word(&key, "columns") && !take_columns(t, values, count)) {
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: missing columns; expected label, x, y and z", t->path, t->line);
    }
    return OST_OK;
}

static ost_status take_row(table *t, const field *fields, int count, ost_landmarks *out, ost_error *err)
{
    const columns *c = &t->columns;
    const int at[3] = {c->x, c->y, c->z};
    ost_pm p[3];
    char location[300];
    snprintf(location, sizeof location, "%.240s:%ld", t->path, t->line);
    if (t->fcsv && !t->has_system)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: no coordinate system; expected '# CoordinateSystem = LPS' or RAS before the first row",
                        location);
    for (int a = 0; a < 3; a++) {
        ost_decimal d;
        if (at[a] >= count)
            return ost_fail(err, OST_ERR_INPUT, "%s: %d column%s; expected the %c coordinate in column %d", location,
                            count, count == 1 ? "" : "s", "xyz"[a], at[a] + 1);
        const field *f = &fields[at[a]];
        if (ost_decimal_read(f->begin, f->begin + f->length, &d) != f->begin + f->length ||
            !ost_decimal_to_pm(&d, &p[a], NULL))
            return ost_fail(err, OST_ERR_INPUT, "%s: column %d, '%.*s', is not a length in millimetres within 8 m",
                            location, at[a] + 1, (int)(f->length < 40 ? f->length : 40), f->begin);
    }
    if (c->label >= count)
        return ost_fail(err, OST_ERR_INPUT, "%s: %d columns; the label was expected in column %d", location, count,
                        c->label + 1);
    return add(location, out, fields[c->label].begin, fields[c->label].length, (ost_pm3){p[0], p[1], p[2]}, t->ras,
               err);
}

static ost_status read_table(const char *path, const char *text, size_t size, ost_landmarks *out, ost_error *err)
{
    const size_t n = strlen(path);
    table t = {.path = path, .columns = {0, 1, 2, 3}};
    t.fcsv = (n > 5 && strcasecmp(path + n - 5, ".fcsv") == 0) ||
             (size > 24 && strncasecmp(text, "# Markups fiducial file", 23) == 0);
    if (t.fcsv)
        t.columns = (columns){11, 1, 2, 3};
    ost_status status = OST_OK;
    for (const char *p = text, *end = text + size; p < end && status == OST_OK;) {
        const char *newline = memchr(p, '\n', (size_t)(end - p)), *stop = newline ? newline : end;
        const char *next = newline ? newline + 1 : end;
        field fields[COLUMNS_MAX];
        t.line++;
        if (stop > p && stop[-1] == '\r')
            stop--;
        while (p < stop && (*p == ' ' || *p == '\t'))
            p++;
        if (p < stop && *p == '#') {
            status = take_comment(&t, p, stop, err);
        } else if (p < stop) {
            const int count = split(p, stop, fields);
            if (out->count > 0 || t.has_columns || !take_columns(&t, fields, count))
                status = take_row(&t, fields, count, out, err);
        }
        p = next;
    }
    return status;
}

/* ----------------------------------------------------------------- reading */

ost_status ost_landmarks_read(const char *path, ost_landmarks *out, ost_error *err)
{
    char *text;
    size_t size;
    *out = (ost_landmarks){0};
    ost_status status = ost_small_text_read(path, FILE_MAX, "landmarks", ".mrk.json, .fcsv or CSV", &text, &size, err);
    if (status == OST_OK)
        status = ost_small_text_is_json(text) ? read_json(path, text, size, out, err)
                                              : read_table(path, text, size, out, err);
    free(text);
    if (status == OST_OK && out->count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: no landmarks in the file; expected at least one", path);
    if (status != OST_OK)
        ost_landmarks_free(out);
    return status;
}
