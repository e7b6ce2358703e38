/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory is bounded by rows, time by bytes: a small gzip file may hold
 * gigabytes of nothing.
 */
#include "io/motion_csv.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

#include <osteon/length.h>

#include "io/text/fields.h"

enum { COLUMNS = 8, LINE = 4096 };
#define TEXT_MAX (INT64_C(1) << 30)
#define TIME_MAX_NS (INT64_C(86400) * 1000000000)
#define FAR_PM (INT64_C(100000) * OST_PM_PER_MM)
#define PM_PER_M (1000.0 * (double)OST_PM_PER_MM)

static const char *const names[COLUMNS] = {"t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"};
static const char expected[] = "t_s,x_m,y_m,z_m,qw,qx,qy,qz";

typedef struct reader {
    const char *path;
    int64_t line, bytes;
    size_t room;
    bool past_header;
    motion *out;
} reader;

bool motion_seen(const motion_row *row)
{
    return row->q[0] != 0 || row->q[1] != 0 || row->q[2] != 0 || row->q[3] != 0;
}

void motion_free(motion *m)
{
    free(m->rows);
    *m = (motion){0};
}

static ost_status fail_field(const reader *r, int column, const char *field, const char *end, const char *wanted, ost_error *err)
{
    char quote[OST_TEXT_QUOTE];
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d (%s) is '%s'; expected %s", r->path, (long long)r->line, column + 1, names[column],
                    ost_text_quote(field, ost_text_field_end(field, end), quote), wanted);
}

static ost_status read_header(reader *r, const char *p, const char *end, ost_error *err)
{
    for (int column = 0; column < COLUMNS; column++) {
        const bool more = ost_text_field_start(&p, end, column) == OST_TEXT_FIELD;
        const char *field_end = more ? ost_text_field_end(p, end) : p;
        const size_t length = (size_t)(field_end - p);
        if (!more || length != strlen(names[column]) || memcmp(p, names[column], length) != 0)
            return fail_field(r, column, p, end, expected, err);
        p = field_end;
    }
    return OST_OK;
}

static ost_status new_row(reader *r, motion_row **row, ost_error *err)
{
    motion *m = r->out;
    if (m->count == MOTION_ROWS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s:%lld: more than %d rows", r->path, (long long)r->line, MOTION_ROWS_MAX);
    if (m->count == r->room) {
        size_t room = r->room ? r->room + r->room / 2 : 1024;
        room = room < MOTION_ROWS_MAX ? room : MOTION_ROWS_MAX;
        motion_row *more = realloc(m->rows, room * sizeof *more);
        if (!more)
            return ost_fail(err, OST_ERR_MEMORY, "%s:%lld: no memory for a motion of %zu rows", r->path, (long long)r->line, room);
        m->rows = more;
        r->room = room;
    }
    *row = &m->rows[m->count];
    return OST_OK;
}

static bool is_nan(const char *p, const char *end)
{
    const char *stop = ost_text_field_end(p, end);
    return stop - p == 3 && (p[0] | 0x20) == 'n' && (p[1] | 0x20) == 'a' && (p[2] | 0x20) == 'n';
}

/* The fields of a row as integers: time in ns, position in pm, quaternion in 2^-30. *seen is false when one of the pose is nan. */
static ost_status read_fields(reader *r, const char *p, const char *end, int64_t value[COLUMNS], bool *seen, ost_error *err)
{
    *seen = true;
    for (int column = 0; column < COLUMNS; column++) {
        ost_decimal d;
        if (ost_text_field_start(&p, end, column) != OST_TEXT_FIELD)
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %d columns, or an empty one; expected %s", r->path, (long long)r->line, column, expected);
        const char *field = p, *stop = ost_text_field_end(p, end);
        p = stop;
        if (column > 0 && is_nan(field, end)) {
            *seen = false;
            continue;
        }
        if (ost_decimal_read(field, stop, &d) != stop)
            return fail_field(r, column, field, end, column ? "a decimal number or nan" : "a decimal number", err);
        const bool small = column == 0 ? ost_decimal_scale(&d, 1000000000, &value[0], NULL) && llabs(value[0]) <= TIME_MAX_NS
                           : column < 4 ? ost_decimal_scale(&d, UINT64_C(1000000000000), &value[column], NULL) && llabs(value[column]) <= FAR_PM
                                        : ost_decimal_scale(&d, 1 << 30, &value[column], NULL) && llabs(value[column]) <= INT64_C(1) << 31;
        if (!small)
            return fail_field(r, column, field, end, column == 0 ? "seconds within a day" : column < 4 ? "metres within 100 m" : "a number from -1 to 1", err);
    }
    return OST_OK;
}

static ost_status read_row(reader *r, const char *p, const char *end, ost_error *err)
{
    int64_t value[COLUMNS];
    bool seen;
    motion_row *row = NULL;
    ost_status status = read_fields(r, p, end, value, &seen, err);
    if (status == OST_OK)
        status = new_row(r, &row, err);
    if (status != OST_OK)
        return status;
    *row = (motion_row){.t_ns = value[0]};
    if (r->out->count > 0 && row->t_ns <= row[-1].t_ns)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: t_s is %.9f, not after the row above, which has %.9f; expected increasing times", r->path,
                        (long long)r->line, (double)row->t_ns * 1e-9, (double)row[-1].t_ns * 1e-9);
    if (seen) {
        double square = 0;
        for (int i = 0; i < 4; i++) {
            row->q[i] = (double)value[4 + i] / (1 << 30);
            square += row->q[i] * row->q[i];
        }
        if (!(fabs(sqrt(square) - 1) <= 0.01))
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the quaternion's length is %.4f; expected 1, w first", r->path, (long long)r->line,
                            sqrt(square));
        for (int i = 0; i < 4; i++)
            row->q[i] /= sqrt(square);
        for (int i = 0; i < 3; i++)
            row->at[i] = (double)value[1 + i] / PM_PER_M;
    }
    r->out->count++;
    return OST_OK;
}

static ost_status read_line(reader *r, char *text, ost_error *err)
{
    const char *p = text, *end = text + strcspn(text, "\r\n");
    if (r->line == 1 && strncmp(p, "\xef\xbb\xbf", 3) == 0)
        p += 3;
    if (ost_text_is_binary(p, end))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: binary bytes; expected text, %s", r->path, (long long)r->line, expected);
    p = ost_text_skip_blanks(p, end);
    if (p == end || *p == '#')
        return OST_OK;
    const bool header = !r->past_header && ost_text_is_header(p, end);
    r->past_header = true;
    return header ? read_header(r, p, end, err) : read_row(r, p, end, err);
}

/* Whether what was read so far could be. */
static ost_status packing(const reader *r, gzFile file, ost_error *err)
{
    int number = Z_OK;
    const char *why = gzerror(file, &number);
    if (number == Z_ERRNO)
        return ost_fail(err, OST_ERR_IO, "%s: reading failed after line %lld: %s", r->path, (long long)r->line, strerror(errno));
    if (number != Z_OK && number != Z_STREAM_END)
        return ost_fail(err, OST_ERR_INPUT, "%s: the gzip data are damaged or cut off after line %lld: %.80s", r->path, (long long)r->line, why);
    return OST_OK;
}

static ost_status read_lines(reader *r, gzFile file, ost_error *err)
{
    char text[LINE];
    while (gzgets(file, text, LINE)) {
        const size_t length = strlen(text);
        r->line++;
        r->bytes += (int64_t)length;
        if (r->bytes > TEXT_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s:%lld: more than %lld bytes of text", r->path, (long long)r->line, (long long)TEXT_MAX);
        /* Without its newline it is the last line, or what is left of a file that was cut off, or none. */
        const bool whole = length > 0 && text[length - 1] == '\n';
        ost_status status = whole ? OST_OK : packing(r, file, err);
        if (status == OST_OK && !whole && (length == 0 || length == LINE - 1 || !gzeof(file)))
            status = ost_fail(err, OST_ERR_INPUT, "%s:%lld: longer than %d bytes, or a zero byte; is this a text of numbers?", r->path,
                              (long long)r->line, LINE - 2);
        if (status == OST_OK)
            status = read_line(r, text, err);
        if (status != OST_OK)
            return status;
    }
    return packing(r, file, err);
}

ost_status motion_read_csv(const char *path, motion *out, ost_error *err)
{
    reader r = {.path = path, .out = out};
    struct stat st;
    *out = (motion){0};
    if (stat(path, &st) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot be opened: %s", path, strerror(errno));
    if (!S_ISREG(st.st_mode))
        return ost_fail(err, OST_ERR_IO, "%s: is no file; a motion is a text file, plain or packed by gzip", path);
    gzFile file = gzopen(path, "rbe");
    if (!file)
        return ost_fail(err, OST_ERR_IO, "%s: cannot be opened: %s", path, strerror(errno));
    ost_status status = read_lines(&r, file, err);
    gzclose(file);
    bool seen = false;
    for (size_t i = 0; i < out->count && !seen; i++)
        seen = motion_seen(&out->rows[i]);
    if (status == OST_OK && !seen)
        status = ost_fail(err, OST_ERR_INPUT, "%s: %zu rows in %lld lines, and in none is the body seen; expected %s", path, out->count,
                          (long long)r.line, expected);
    if (status != OST_OK)
        motion_free(out);
    return status;
}
