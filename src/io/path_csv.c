/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Paths as text: a row is a tick.
 *
 *   t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool]
 *   0,-12.5,3,40.25,1,0,0,0
 *   0.001,-12.5,3,40.23,0.99999876,0,0,0.00157
 *
 * Decimals are read exactly: time to nanoseconds, positions to picometres,
 * quaternions to 2^-30, each RHE.  Ten decimals name every multiple of 2^-30
 * (half a unit of the tenth is 0.054 of one), so that a written path reads
 * back as the same integers.
 */
#include "core/conditions.h"

#include <osteon/io.h>

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/outfile.h"
#include "io/path_csv.h"
#include "io/text/fields.h"
#include "io/text/lines.h"

enum { COLUMNS = 8, COLUMNS_MAX = 9 };
static const char *const column_names[COLUMNS_MAX] = {"t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "tool"};
static const char expected_row[] = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool]";

/* -------------------------------------------------------------------- reading */

typedef struct reader {
    const char *path;
    int64_t line;
    int columns;      /* of the first row or header; 0 before */
    bool past_header;
    size_t room;
    ost_path *out;
} reader;

static ost_status fail_field(const reader *r, int column, const char *field, const char *end, const char *expected, ost_error *err)
{
    char quote[OST_TEXT_QUOTE];
    const char *field_end = ost_text_field_end(field, end);
    if (ost_text_is_binary(field, field_end))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: binary bytes; expected %s", r->path, (long long)r->line, expected_row);
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d (%s) is '%s'; expected %s", r->path, (long long)r->line, column + 1,
                    column_names[column], ost_text_quote(field, field_end, quote), expected);
}

static int count_columns(const char *p, const char *end)
{
    int columns = 0;
    while (ost_text_field_start(&p, end, columns) == OST_TEXT_FIELD) {
        columns++;
        p = ost_text_field_end(p, end);
    }
    return columns;
}

static ost_status fail_columns(const reader *r, const char *p, const char *end, ost_error *err)
{
    if (r->columns == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %d columns; expected %s", r->path, (long long)r->line, count_columns(p, end),
                        expected_row);
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %d columns, or an empty one; the rows above have %d", r->path, (long long)r->line,
                    count_columns(p, end), r->columns);
}

/* Columns in another order would be misread, so a header must name ours. */
static ost_status read_header(reader *r, const char *p, const char *end, ost_error *err)
{
    int column = 0;
    for (; ost_text_field_start(&p, end, column) == OST_TEXT_FIELD; column++) {
        const char *field_end = ost_text_field_end(p, end);
        if (column >= COLUMNS_MAX)
            break;
        size_t length = (size_t)(field_end - p);
        if (strlen(column_names[column]) != length || memcmp(p, column_names[column], length) != 0) {
            char quote[OST_TEXT_QUOTE];
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d is called '%s'; expected %s", r->path, (long long)r->line, column + 1,
                            ost_text_quote(p, field_end, quote), expected_row);
        }
        p = field_end;
    }
    if (column < COLUMNS || p != end)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the header has not the columns %s", r->path, (long long)r->line, expected_row);
    r->columns = column;
    return OST_OK;
}

static ost_status new_tick(reader *r, ost_tick **tick, ost_error *err)
{
    ost_path *path = r->out;
    if (path->count == OST_PATH_TICKS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s:%lld: more than %d rows", r->path, (long long)r->line, OST_PATH_TICKS_MAX);
    if (path->count == r->room) {
        size_t room = r->room ? r->room + r->room / 2 : 1024;
        ost_tick *more = realloc(path->ticks, room * sizeof *more);
        if (!more)
            return ost_fail(err, OST_ERR_MEMORY, "%s:%lld: no memory for a path of %zu ticks", r->path, (long long)r->line, room);
        path->ticks = more;
        r->room = room;
    }
    *tick = &path->ticks[path->count];
    return OST_OK;
}

static ost_status read_row(reader *r, const char *p, const char *end, ost_error *err)
{
    const char *begin = p, *field[COLUMNS_MAX] = {NULL};
    ost_decimal value[COLUMNS_MAX];
    int column = 0;
    ost_text_field_kind kind;
    for (; (kind = ost_text_field_start(&p, end, column)) == OST_TEXT_FIELD && column < COLUMNS_MAX; column++) {
        field[column] = p;
        p = ost_decimal_read(p, end, &value[column]);
        if (!p || (p < end && !ost_text_ends_field(*p)))
            return fail_field(r, column, field[column], end, "a decimal number", err);
    }
    if (kind != OST_TEXT_END || column < COLUMNS || (r->columns && column != r->columns) || memchr(p, 0, (size_t)(end - p)))
        return fail_columns(r, begin, end, err);
    r->columns = column;

    ost_tick *tick = NULL;
    ost_status status = new_tick(r, &tick, err);
    if (status != OST_OK)
        return status;
    int64_t tool = 0;
    bool exact = true;
    if (!ost_decimal_scale(&value[0], 1000000000, &tick->t_ns, NULL))
        return fail_field(r, 0, field[0], end, "a time in seconds within 9 * 10^9", err);
    if (column == COLUMNS_MAX && (!ost_decimal_scale(&value[8], 1, &tool, &exact) || !exact || tool < 0 || tool > INT32_MAX))
        return fail_field(r, 8, field[8], end, "a tool's number from 0", err);
    tick->tool = (int32_t)tool;
    tick->rpm = OST_RPM_ON;
    status = ost_pose_from_decimals(&value[1], &value[4], &tick->pose, err);
    if (status != OST_OK) {
        (void)ost_fail_context(err, "%s:%lld", r->path, (long long)r->line);
        return status;
    }
    if (r->out->count > 0 && tick->t_ns <= tick[-1].t_ns)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: t_s is %.9f, not after the row above, which has %.9f; expected increasing times",
                        r->path, (long long)r->line, (double)tick->t_ns * 1e-9, (double)tick[-1].t_ns * 1e-9);
    r->out->count++;
    return OST_OK;
}

static ost_status read_line(reader *r, const char *p, const char *newline, ost_error *err)
{
    const char *end = newline > p && newline[-1] == '\r' ? newline - 1 : newline;
    r->line++;
    if (newline - p > OST_TEXT_LINE_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the line is longer than %d bytes; is this a path?", r->path, (long long)r->line,
                        OST_TEXT_LINE_MAX);
    p = ost_text_skip_blanks(p, end);
    if (p == end)
        return OST_OK;
    if (*p == '#')
        return !memchr(p, 0, (size_t)(end - p))
                   ? OST_OK
                   : ost_fail(err, OST_ERR_INPUT, "%s:%lld: a zero byte; expected a line of text", r->path, (long long)r->line);
    bool header = !r->past_header && ost_text_is_header(p, end);
    r->past_header = true;
    return header ? read_header(r, p, end, err) : read_row(r, p, end, err);
}

ost_status ost_path_read_csv(const char *path, ost_path *out, ost_error *err)
{
    *out = (ost_path){0};
    reader r = {.path = path, .out = out};
    ost_text_lines *lines;
    ost_status status = ost_text_lines_open(path, &lines, err);
    if (status != OST_OK)
        return status;
    ost_text_block block = {NULL, NULL};
    do {
        status = ost_text_lines_next(lines, r.line + 1, &block, err);
        const char *p = block.begin;
        while (status == OST_OK && p < block.end) {
            const char *newline = memchr(p, '\n', (size_t)(block.end - p));
            status = read_line(&r, p, newline, err);
            p = newline + 1;
        }
    } while (status == OST_OK && block.begin < block.end);
    ost_text_lines_close(lines);
    if (status == OST_OK && out->count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: holds no row in %lld lines; expected %s", path, (long long)r.line, expected_row);
    if (status != OST_OK)
        ost_path_free(out);
    return status;
}

/* -------------------------------------------------------------------- writing */

enum { NUMBER = 40 };

/* value / 10^places, without zeros at its end; 0 <= places <= 18. */
static const char *format_scaled(int64_t value, int places, char text[NUMBER])
{
    uint64_t rest = value < 0 ? -(uint64_t)value : (uint64_t)value;
    char digits[NUMBER];
    int at = NUMBER;
    digits[--at] = 0;
    bool kept = false;
    for (int i = 0; i < places; i++, rest /= 10) {
        if (rest % 10 == 0 && !kept)
            continue;
        kept = true;
        digits[--at] = (char)('0' + rest % 10);
    }
    if (kept)
        digits[--at] = '.';
    do {
        digits[--at] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest > 0);
    if (value < 0)
        digits[--at] = '-';
    memcpy(text, digits + at, (size_t)(NUMBER - at));
    return text;
}

/* |q| < 2^31, so the product is below 2^65: 128 bits. */
static const char *format_component(int32_t q, char text[NUMBER])
{
    return format_scaled((int64_t)ost_rhe_div128((ost_i128)q * INT64_C(10000000000), OST_Q30_ONE), 10, text);
}

ost_status ost_path_put_tick(ost_outfile *out, const ost_tick *tick, bool tools, ost_error *err)
{
    char n[8][NUMBER];
    const ost_pose *p = &tick->pose;
    ost_status status = ost_outfile_printf(out, err, "%s,%s,%s,%s,%s,%s,%s,%s", format_scaled(tick->t_ns, 9, n[0]),
                                           format_scaled(p->t.x, 9, n[1]), format_scaled(p->t.y, 9, n[2]),
                                           format_scaled(p->t.z, 9, n[3]), format_component(p->qw, n[4]), format_component(p->qx, n[5]),
                                           format_component(p->qy, n[6]), format_component(p->qz, n[7]));
    if (status == OST_OK && tools)
        status = ost_outfile_printf(out, err, ",%" PRId32, tick->tool);
    return status;
}

ost_status ost_path_write_csv(const char *path, const ost_path *in, ost_error *err)
{
    bool tools = false;
    for (size_t i = 0; i < in->count; i++)
        tools |= in->ticks[i].tool != 0;
    ost_outfile *out;
    ost_status status = ost_outfile_open(path, &out, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_printf(out, err, "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz%s\n", tools ? ",tool" : "");
    for (size_t i = 0; i < in->count && status == OST_OK; i++) {
        status = ost_path_put_tick(out, &in->ticks[i], tools, err);
        if (status == OST_OK)
            status = ost_outfile_write(out, "\n", 1, err);
    }
    if (status == OST_OK)
        return ost_outfile_commit(out, err);
    ost_outfile_discard(out);
    return status;
}
