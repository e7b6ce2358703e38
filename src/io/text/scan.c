/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/text/scan.h"

#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/text/lattice.h"

enum { BATCH = 2048, SET_SIZE = 2 * OST_DIM_MAX };

_Static_assert(OST_LATTICE_UNIT_PLACES == -OST_TEXT_PLACES_MIN &&
                   OST_LATTICE_UNITS == OST_TEXT_PLACES_MAX - OST_TEXT_PLACES_MIN + 1,
               "units are numbered by places");

/* ------------------------------------------------------- distinct coordinates */

/* Adds a coordinate to a hash set. The set uses open addressing and is at most half full. */
static ost_status set_add(const char *path, ost_text_axis *axis, int a, ost_pm value, int64_t line, ost_error *err)
{
    size_t at = (size_t)((uint64_t)value * UINT64_C(0x9e3779b97f4a7c15) >> 32) % SET_SIZE;
    while (axis->set[at].line != 0) {
        if (axis->set[at].value == value)
            return OST_OK;
        at = (at + 1) % SET_SIZE;
    }
    if (axis->distinct == OST_DIM_MAX)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s:%lld: %d different values of %c; expected at most %d on a grid; if the positions are "
                        "noisy, pass --spacing", path, (long long)line, OST_DIM_MAX + 1, "xyz"[a], OST_DIM_MAX);
    axis->set[at] = (ost_text_coordinate){value, line};
    axis->distinct++;
    return OST_OK;
}

static int by_value(const void *a, const void *b)
{
    ost_pm x = ((const ost_text_coordinate *)a)->value, y = ((const ost_text_coordinate *)b)->value;
    return (x > y) - (x < y);
}

static void set_sort(ost_text_axis *axis)
{
    size_t filled = 0;
    for (size_t i = 0; i < SET_SIZE; i++)
        if (axis->set[i].line != 0)
            axis->set[filled++] = axis->set[i];
    qsort(axis->set, filled, sizeof *axis->set, by_value);
}

/* ---------------------------------------------------------------------- facts */

/* Reads three values: lengths in mm, such as "0.47 0.47 1", or numbers of voxels, such as "256 234 201". */
static bool read_three(const char *text, bool lengths, int64_t out[3])
{
    const char *end = text + strlen(text);
    if (end - text >= OST_META_VALUE)
        return false;
    for (int a = 0; a < 3; a++) {
        ost_decimal value;
        bool exact;
        if (ost_text_field_start(&text, end, a) != OST_TEXT_FIELD)
            return false;
        text = ost_decimal_read(text, end, &value);
        if (!text || (text < end && !ost_text_ends_field(*text)))
            return false;
        if (lengths ? !ost_decimal_to_pm(&value, &out[a], NULL)
                    : !ost_decimal_scale(&value, 1, &out[a], &exact) || !exact || out[a] < 1 || out[a] > OST_DIM_MAX)
            return false;
    }
    return ost_text_skip_blanks(text, end) == end;
}

static ost_status bad_fact(const ost_text_parser *parser, const ost_text_fact *fact, const char *expected,
                           ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: fact '%s' is '%.60s'; expected %s", parser->path,
                    (long long)parser->line, fact->key, fact->value, expected);
}

/* Stores the three values of a header fact. If the fact is repeated, the values must be equal. */
static ost_status take_own(const ost_text_parser *parser, const ost_text_fact *fact, const int64_t value[3],
                           ost_text_own *own, ost_error *err)
{
    if (own->line != 0 && memcmp(own->value, value, sizeof own->value) != 0)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s:%lld: fact '%s' is '%.60s', but line %lld gives another; remove one of them",
                        parser->path, (long long)parser->line, fact->key, fact->value, (long long)own->line);
    own->line = own->line ? own->line : parser->line;
    memcpy(own->value, value, sizeof own->value);
    return OST_OK;
}

static ost_status take_spacing(const ost_text_facts *facts, const ost_text_parser *parser, const ost_text_fact *fact,
                               ost_error *err)
{
    ost_text_summary *summary = facts->summary;
    const ost_pm given[3] = {facts->given.x, facts->given.y, facts->given.z};
    ost_pm spacing[3];
    if (!read_three(fact->value, true, spacing) || spacing[0] <= 0 || spacing[1] <= 0 || spacing[2] <= 0)
        return bad_fact(parser, fact, "three lengths above 0 in mm", err);
    for (int a = 0; a < 3; a++)
        summary->axis[a].given = given[a] ? given[a] : spacing[a];
    return take_own(parser, fact, spacing, &summary->own_spacing, err);
}

static ost_status take_other(const ost_text_facts *facts, const ost_text_parser *parser, const ost_text_fact *fact,
                             ost_error *err)
{
    ost_status status = ost_meta_set(&facts->summary->meta, fact->key, fact->value, err);
    if (status == OST_OK)
        return OST_OK;
    (void)ost_fail_context(err, "%s:%lld", parser->path, (long long)parser->line);
    if (err)
        err->status = OST_ERR_INPUT;
    return OST_ERR_INPUT;
}

ost_status ost_text_fact_take(void *facts, const ost_text_parser *parser, const ost_text_fact *fact, ost_error *err)
{
    const ost_text_facts *s = facts;
    int64_t value[3];
    if (strcmp(fact->key, "spacing_mm") == 0)
        return take_spacing(s, parser, fact, err);
    if (strcmp(fact->key, "origin_mm") == 0)
        return read_three(fact->value, true, value) ? take_own(parser, fact, value, &s->summary->own_origin, err)
                                                    : bad_fact(parser, fact, "three lengths in mm", err);
    if (strcmp(fact->key, "dims") == 0)
        return read_three(fact->value, false, value)
                   ? take_own(parser, fact, value, &s->summary->own_dims, err)
                   : bad_fact(parser, fact, "three numbers of voxels from 1 to 16384", err);
    return take_other(s, parser, fact, err);
}

/* ----------------------------------------------------------------------- pass */

static ost_status add_rows(const char *path, ost_text_summary *summary, const ost_text_row *rows, size_t count,
                           ost_pm last[3], ost_error *err)
{
    for (size_t i = 0; i < count; i++) {
        const ost_text_row *row = &rows[i];
        for (int a = 0; a < 3; a++) {
            ost_text_axis *axis = &summary->axis[a];
            ost_pm value = row->position[a];
            axis->units |= 1u << (row->places[a] + OST_LATTICE_UNIT_PLACES);
            summary->rounded_positions += row->rounded >> a & 1;
            axis->rounded |= row->rounded >> a & 1;
            if (value == last[a])
                continue;
            last[a] = value;
            axis->min = value < axis->min ? value : axis->min;
            axis->max = value > axis->max ? value : axis->max;
            if (axis->given == 0) {
                ost_status status = set_add(path, axis, a, value, row->line, err);
                if (status != OST_OK)
                    return status;
            }
        }
    }
    ost_text_fingerprint_add(&summary->fingerprint, rows, count);
    return OST_OK;
}

static ost_status hash_rows(ost_hasher *hasher, const ost_text_row *rows, size_t count, ost_error *err)
{
    struct {
        int64_t x, y, z;
        int32_t density;
        uint32_t zero;
    } records[BATCH];
    _Static_assert(sizeof records == BATCH * 32, "a record has 32 bytes");
    for (size_t i = 0; i < count; i++) {
        records[i].x = rows[i].position[0];
        records[i].y = rows[i].position[1];
        records[i].z = rows[i].position[2];
        records[i].density = rows[i].density;
        records[i].zero = 0;
    }
    return ost_hasher_add(hasher, records, count * sizeof records[0], err);
}

static ost_status check_complete(const ost_text_source *source, const ost_text_summary *summary, ost_error *err)
{
    const char *path = source->parser.path;
    int64_t lines = source->parser.line;
    if (summary->fingerprint.rows == 0 && lines == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: file is empty; expected lines of x y z density", path);
    if (summary->fingerprint.rows == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: no line is a sample; expected lines of x y z density", path);
    const ost_text_own *dims = &summary->own_dims;
    if (dims->line == 0)
        return OST_OK;
    /* The product of the three dims is at most (2^14)^3, so it does not overflow. */
    int64_t expected = dims->value[0] * dims->value[1] * dims->value[2];
    if ((uint64_t)expected != summary->fingerprint.rows)
        return ost_fail(
            err, OST_ERR_INPUT, "%s:%lld: ends after %llu samples; line %lld says %lld x %lld x %lld, which are %lld",
            path, (long long)lines, (unsigned long long)summary->fingerprint.rows, (long long)dims->line,
            (long long)dims->value[0], (long long)dims->value[1], (long long)dims->value[2], (long long)expected);
    if (!ost_text_lines_terminated(source->lines))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the last line has no line end: the file is truncated", path,
                        (long long)lines);
    return OST_OK;
}

void ost_text_summary_begin(ost_text_summary *summary, ost_pm3 given)
{
    const ost_pm by_option[3] = {given.x, given.y, given.z};
    *summary = (ost_text_summary){0};
    for (int a = 0; a < 3; a++)
        summary->axis[a] = (ost_text_axis){.min = INT64_MAX, .max = INT64_MIN, .given = by_option[a]};
}

ost_status ost_text_scan(ost_text_source *source, ost_pm3 given, ost_hasher *hasher, ost_progress *progress, void *user,
                         ost_text_summary *summary, ost_error *err)
{
    const char *path = source->parser.path;
    ost_text_facts facts = {summary, given};
    /* position of the previous row; INT64_MIN, which is not a valid coordinate, before the first row */
    ost_pm last[3] = {INT64_MIN, INT64_MIN, INT64_MIN};
    ost_text_summary_begin(summary, given);
    ost_text_row *rows = malloc(BATCH * sizeof *rows);
    ost_status status = rows ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory to read %d lines", path,
                                                 BATCH);
    for (int a = 0; a < 3 && status == OST_OK; a++) {
        summary->axis[a].set = calloc(SET_SIZE, sizeof *summary->axis[a].set);
        if (!summary->axis[a].set)
            status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %d coordinates", path, OST_DIM_MAX);
    }
    source->parser.fact = ost_text_fact_take;
    source->parser.user = &facts;
    size_t count = 1;
    for (unsigned batch = 0; status == OST_OK && count > 0; batch++) {
        status = ost_text_source_next(source, rows, BATCH, &count, err);
        if (status == OST_OK)
            status = add_rows(path, summary, rows, count, last, err);
        if (status == OST_OK && hasher)
            status = hash_rows(hasher, rows, count, err);
        if (status == OST_OK && progress && batch % 64 == 0 &&
            !progress(user, "samples", ost_text_lines_share(source->lines)))
            status = ost_fail(err, OST_ERR_CANCELLED, "%s: reading was cancelled", path);
    }
    source->parser.fact = NULL;
    free(rows);
    if (status == OST_OK)
        status = check_complete(source, summary, err);
    for (int a = 0; a < 3 && status == OST_OK; a++)
        set_sort(&summary->axis[a]);
    return status;
}

void ost_text_summary_free(ost_text_summary *summary)
{
    for (int a = 0; a < 3; a++) {
        free(summary->axis[a].set);
        summary->axis[a].set = NULL;
    }
}

/* ------------------------------------------------------------------- geometry */

static ost_status find_spacing(const char *path, const ost_text_summary *summary, ost_pm spacing[3], ost_error *err)
{
    size_t total = 0;
    for (int a = 0; a < 3; a++)
        total += summary->axis[a].given ? 0 : summary->axis[a].distinct;
    if (total == 0)
        return OST_OK;
    ost_lattice_axis axes[3] = {{0}, {0}, {0}};
    ost_pm *values = malloc(total * sizeof *values);
    int64_t *lines = malloc(total * sizeof *lines);
    if (!values || !lines) {
        free(values);
        free(lines);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu coordinates", path, total);
    }
    size_t used = 0;
    for (int a = 0; a < 3; a++) {
        const ost_text_axis *axis = &summary->axis[a];
        if (axis->given)
            continue;
        axes[a] = (ost_lattice_axis){
            .name = "xyz"[a],
            .count = axis->distinct,
            .value = values + used,
            .line = lines + used,
            .units = axis->units,
            .rounded = axis->rounded,
        };
        for (size_t i = 0; i < axis->distinct; i++, used++) {
            values[used] = axis->set[i].value;
            lines[used] = axis->set[i].line;
        }
    }
    ost_status status = ost_lattice_find(path, axes, spacing, err);
    free(values);
    free(lines);
    return status;
}

/*
 * Returns an error if the origin stated in the text and the smallest coordinate differ by more than an eighth of a
 * voxel. This tolerance allows for rounded digits.
 */
static ost_status check_origin(const char *path, const ost_text_summary *summary, int a, ost_pm spacing, ost_error *err)
{
    int64_t off = summary->axis[a].min - summary->own_origin.value[a];
    if (8 * (off < 0 ? -off : off) <= spacing)
        return OST_OK;
    char stated[OST_PM_TEXT], is[OST_PM_TEXT];
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the declared origin is %c = %s mm, but its lowest is %s mm", path,
                    (long long)summary->own_origin.line, "xyz"[a], ost_pm_format(summary->own_origin.value[a],
                    stated), ost_pm_format(summary->axis[a].min, is));
}

ost_status ost_text_geometry(const char *path, const ost_text_summary *summary, ost_geometry *out, bool inferred[3],
                             ost_error *err)
{
    ost_pm spacing[3], origin[3];
    int32_t dims[3];
    for (int a = 0; a < 3; a++) {
        spacing[a] = summary->axis[a].given;
        inferred[a] = spacing[a] == 0;
        if (!inferred[a] && (spacing[a] < OST_SPACING_MIN || spacing[a] > OST_SPACING_MAX))
            return ost_fail(err, OST_ERR_RANGE, "%s: a spacing of %.9g mm along %c; expected 0.001 to 100 mm", path,
                            ost_pm_to_mm(spacing[a]), "xyz"[a]);
    }
    ost_status status = find_spacing(path, summary, spacing, err);
    for (int a = 0; a < 3 && status == OST_OK; a++) {
        const ost_text_axis *axis = &summary->axis[a];
        origin[a] = summary->own_origin.line ? summary->own_origin.value[a] : axis->min;
        if (summary->own_origin.line)
            status = check_origin(path, summary, a, spacing[a], err);
        /*
         * A spacing that was found from the coordinates may be as small as 1 pm. The number of steps may then be
         * 1.7 * 10^13; it is clamped to the range of int32, and the later check of the geometry refuses the dims.
         */
        int64_t steps = ost_rhe_div(axis->max - origin[a], spacing[a]);
        dims[a] = (int32_t)(steps < 0 ? 0 : steps > INT32_MAX - 1 ? INT32_MAX - 1 : steps) + 1;
        if (status == OST_OK && summary->own_dims.line && dims[a] != summary->own_dims.value[a])
            status = ost_fail(err, OST_ERR_INPUT,
                              "%s:%lld: the declared dims are %lld voxels along %c, but its positions make %d", path,
                              (long long)summary->own_dims.line, (long long)summary->own_dims.value[a], "xyz"[a],
                              (int)dims[a]);
    }
    if (status != OST_OK)
        return status;
    *out = (ost_geometry){
        .dims = {dims[0], dims[1], dims[2]},
        .spacing = {spacing[0], spacing[1], spacing[2]},
        .origin = {origin[0], origin[1], origin[2]},
    };
    return ost_geometry_check(out, path, err);
}
