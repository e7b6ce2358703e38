/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes paths as text (docs/spec/arithmetic.md, AR-PATH). Each row with a pose is a tick.
 *
 *   t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm]      or x_m,y_m,z_m; plain or gzip
 *   0,-12.5,3,40.25,1,0,0,0
 *   0.001,nan,nan,nan,nan,nan,nan,nan                    tracking lost: the next row is lifted
 *   0.002,-12.5,3,40.23,0.99999876,0,0,0.00157
 *
 *   file --lines, gzip--> rows --read_row--> ticks --mark_gaps--> ticks, some of them lifted
 *
 * Decimals are read exactly and then rounded half to even: times to nanoseconds, positions to picometres,
 * quaternions to multiples of 2^-30. Ten decimals identify every multiple of 2^-30 (half a unit of the tenth
 * decimal is 0.054 * 2^-30), so a written path is read back as the same integers.
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

/* Indices of the columns. The columns of a pose come first. A header may name further columns. */
enum { POSE_COLUMNS = 8, TOOL = POSE_COLUMNS, LIFTED, RPM, KINDS, SEEN_COLUMNS = 256, NOT_READ = KINDS };
static const char *const column_names[2][KINDS] = {
    {"t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "tool", "lifted", "rpm"},
    {"t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "tool", "lifted", "rpm"}};
static const char expected_row[] = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm]";

/* Limit on the unpacked bytes of a gzip file, because a small gzip file may expand to gigabytes. */
#define UNPACKED_MAX (INT64_C(1) << 30)

#define GAP_LEAST_NS INT64_C(50000000)
#define JUMP_LEAST_PM (5 * OST_PM_PER_MM)
enum { TIMES_MEDIAN = 10 };

/* -------------------------------------------------------------------- reading */

typedef struct reader {
    const char *path;
    int64_t line, bytes, t_ns; /* numbers of lines and bytes read so far, and time of the last row in ns */
    /* number of columns that a row must have, or minimum number if there is a header; 0 before the first row */
    int columns;
    uint8_t kind[SEEN_COLUMNS]; /* for each column, the index of its name in column_names, or NOT_READ */
    bool past_header, header, metres, lifted_column;
    bool lost;         /* true if the last row had no pose */
    size_t capacity;
    ost_path *out;
    ost_path_report report;
} reader;

static ost_status fail_field(const reader *r, int column, const char *field, const char *end, const char *expected,
                             ost_error *err)
{
    char quote[OST_TEXT_QUOTE];
    const char *field_end = ost_text_field_end(field, end);
    if (ost_text_is_binary(field, field_end))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: binary data; expected %s", r->path, (long long)r->line,
                        expected_row);
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d (%s) is '%s'; expected %s", r->path, (long long)r->line,
                    column + 1, column_names[r->metres][r->kind[column]], ost_text_quote(field, field_end, quote),
                    expected);
}

/* Counts the values before the first empty column or the end of the row. Sets *empty to true if a column is empty. */
static int count_columns(const char *p, const char *end, bool *empty)
{
    int columns = 0;
    ost_text_field_kind kind;
    for (; (kind = ost_text_field_start(&p, end, columns)) == OST_TEXT_FIELD; columns++)
        p = ost_text_field_end(p, end);
    *empty = kind == OST_TEXT_EMPTY;
    return columns;
}

static ost_status fail_columns(const reader *r, const char *p, const char *end, ost_error *err)
{
    bool empty;
    const int columns = count_columns(p, end, &empty);
    if (r->columns == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %d columns; expected %s", r->path, (long long)r->line, columns,
                        expected_row);
    if (memchr(p, 0, (size_t)(end - p)))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: a zero byte; expected a line of text", r->path,
                        (long long)r->line);
    if (empty)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d is empty; expected %d values", r->path,
                        (long long)r->line, columns + 1, r->columns);
    return ost_fail(err, OST_ERR_INPUT,
                    r->header ? "%s:%lld: %d values; the header requires %d"
                              : "%s:%lld: %d values; expected %d, as in the rows above",
                    r->path, (long long)r->line, columns, r->columns);
}

static bool is_name(const char *field, const char *end, const char *name)
{
    return strlen(name) == (size_t)(end - field) && memcmp(name, field, (size_t)(end - field)) == 0;
}

/*
 * Reads the header. The first eight columns must have the standard names in the standard order, because columns in
 * another order would be misread. Further columns are identified by their names (AR-PATH-2).
 */
static ost_status read_header(reader *r, const char *p, const char *end, ost_error *err)
{
    int column = 0, needed = POSE_COLUMNS;
    char quote[OST_TEXT_QUOTE];
    bool named[KINDS] = {false};
    for (; ost_text_field_start(&p, end, column) == OST_TEXT_FIELD; column++) {
        const char *field = p;
        p = ost_text_field_end(p, end);
        if (column == SEEN_COLUMNS)
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the header has more than %d columns", r->path,
                            (long long)r->line, SEEN_COLUMNS);
        if (column == 1)
            r->metres = is_name(field, p, column_names[1][1]);
        int kind = column < POSE_COLUMNS ? column : NOT_READ;
        for (int k = POSE_COLUMNS; k < KINDS && column >= POSE_COLUMNS; k++)
            kind = is_name(field, p, column_names[0][k]) ? k : kind;
        if ((column == 2 || column == 3) && is_name(field, p, column_names[!r->metres][column]))
            return ost_fail(err, OST_ERR_INPUT,
                            "%s:%lld: column %d is '%s', but column 2 is '%s'; expected the same unit", r->path,
                            (long long)r->line, column + 1, column_names[!r->metres][column],
                            column_names[r->metres][1]);
        if (column < POSE_COLUMNS && !is_name(field, p, column_names[r->metres][column]))
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d is named '%s'; expected %s, or x_m,y_m,z_m",
                            r->path, (long long)r->line, column + 1, ost_text_quote(field, p, quote), expected_row);
        if (kind != NOT_READ && named[kind])
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d is a second '%s'", r->path, (long long)r->line,
                            column + 1, column_names[0][kind]);
        if (kind != NOT_READ) {
            named[kind] = true;
            needed = column + 1;
        }
        r->kind[column] = (uint8_t)kind;
    }
    if (column < POSE_COLUMNS || (p != end && *p != '#'))
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: missing columns in the header; expected %s", r->path,
                        (long long)r->line, expected_row);
    r->columns = needed;
    r->header = true;
    r->lifted_column = named[LIFTED];
    return OST_OK;
}

static ost_status new_tick(reader *r, ost_tick **tick, ost_error *err)
{
    ost_path *path = r->out;
    if (path->count == OST_PATH_TICKS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s:%lld: more than %d rows", r->path, (long long)r->line,
                        OST_PATH_TICKS_MAX);
    if (path->count == r->capacity) {
        size_t capacity = r->capacity ? r->capacity + r->capacity / 2 : 1024;
        ost_tick *more = realloc(path->ticks, capacity * sizeof *more);
        if (!more)
            return ost_fail(err, OST_ERR_MEMORY, "%s:%lld: out of memory for a path of %zu ticks", r->path,
                            (long long)r->line, capacity);
        path->ticks = more;
        r->capacity = capacity;
    }
    *tick = &path->ticks[path->count];
    return OST_OK;
}

static bool is_nan(const char *p, const char *stop)
{
    return stop - p == 3 && (p[0] | 0x20) == 'n' && (p[1] | 0x20) == 'a' && (p[2] | 0x20) == 'n';
}

/*
 * The fields of a row, indexed by the kind of their column; 0 if missing. `posed` is false if a field of the pose is
 * nan.
 */
typedef struct row {
    ost_decimal value[KINDS];
    const char *field[KINDS];
    int column[KINDS];
    bool posed;
} row;

static ost_status read_fields(reader *r, const char *p, const char *end, row *out, ost_error *err)
{
    const char *begin = p;
    int column = 0;
    ost_text_field_kind kind;
    *out = (row){.posed = true};
    for (; (kind = ost_text_field_start(&p, end, column)) == OST_TEXT_FIELD &&
           column < (r->columns ? r->columns : POSE_COLUMNS + 1);
         column++) {
        const char *field = p, *stop = ost_text_field_end(p, end);
        const int k = r->kind[column];
        p = stop;
        if (k == NOT_READ)
            continue;
        out->field[k] = field;
        out->column[k] = column;
        if (k > 0 && k < POSE_COLUMNS && is_nan(field, stop))
            out->posed = false;
        else if (ost_decimal_read(field, end, &out->value[k]) != stop)
            return fail_field(r, column, field, end, k == LIFTED ? "0 or 1" :
                              k > 0 && k < POSE_COLUMNS ? "a decimal number or nan" : "a decimal number", err);
    }
    const bool complete = r->header
                              ? column == r->columns
                              : kind == OST_TEXT_END && column >= POSE_COLUMNS && (!r->columns || column == r->columns);
    if (!complete || memchr(begin, 0, (size_t)(end - begin)))
        return fail_columns(r, begin, end, err);
    r->columns = column;
    return OST_OK;
}

static ost_status read_row(reader *r, const char *p, const char *end, ost_error *err)
{
    row in;
    ost_tick *tick = NULL;
    int64_t t_ns = 0, tool = 0, lifted = 0, rpm = OST_RPM_OF_DEVICE;
    bool exact = true;
    ost_status status = read_fields(r, p, end, &in, err);
    if (status != OST_OK)
        return status;
    if (!ost_decimal_scale(&in.value[0], 1000000000, &t_ns, NULL) || llabs(t_ns) > OST_PATH_TIME_MAX_NS)
        return fail_field(r, 0, in.field[0], end, "a time in seconds within 4 * 10^9", err);
    if (in.field[TOOL] &&
        (!ost_decimal_scale(&in.value[TOOL], 1, &tool, &exact) || !exact || tool < 0 || tool > INT32_MAX))
        return fail_field(r, in.column[TOOL], in.field[TOOL], end, "a tool's number from 0", err);
    if (in.field[LIFTED] &&
        (!ost_decimal_scale(&in.value[LIFTED], 1, &lifted, &exact) || !exact || lifted < 0 || lifted > 1))
        return fail_field(r, in.column[LIFTED], in.field[LIFTED], end, "0 or 1", err);
    if (in.field[RPM] &&
        (!ost_decimal_scale(&in.value[RPM], 1, &rpm, &exact) || !exact || rpm < OST_RPM_OF_DEVICE || rpm > OST_RPM_MAX))
        return fail_field(r, in.column[RPM], in.field[RPM], end,
                          "revolutions per minute from 0 to 3000, -1 (speed unknown) or -2 (pose of the hand)", err);
    if (r->report.rows > 0 && t_ns <= r->t_ns)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s:%lld: t_s is %.9f, not after the row above, which has %.9f; expected increasing times",
                        r->path, (long long)r->line, (double)t_ns * 1e-9, (double)r->t_ns * 1e-9);
    r->report.begin_ns = r->report.rows++ ? r->report.begin_ns : t_ns;
    r->report.end_ns = r->t_ns = t_ns;
    if (!in.posed) {
        r->report.lost_rows++;
        r->lost = true;
        return OST_OK;
    }
    for (int a = 1; a <= 3 && r->metres; a++)
        in.value[a].exponent += 3;
    if ((status = new_tick(r, &tick, err)) != OST_OK)
        return status;
    *tick = (ost_tick){
        .t_ns = t_ns, .tool = (int32_t)tool, .rpm = (int32_t)rpm, .lifted = r->out->count > 0 && (lifted || r->lost)};
    status = ost_pose_from_decimals(&in.value[1], &in.value[4], &tick->pose, err);
    if (status != OST_OK) {
        (void)ost_fail_context(err, "%s:%lld", r->path, (long long)r->line);
        return status;
    }
    r->lost = false;
    r->out->count++;
    return OST_OK;
}

static ost_status read_line(reader *r, const char *p, const char *newline, ost_error *err)
{
    const char *end = newline > p && newline[-1] == '\r' ? newline - 1 : newline;
    r->line++;
    if (newline - p > OST_TEXT_LINE_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the line is longer than %d bytes; expected a path as CSV",
                        r->path, (long long)r->line, OST_TEXT_LINE_MAX);
    p = ost_text_skip_blanks(p, end);
    if (p == end)
        return OST_OK;
    if (*p == '#')
        return !memchr(p, 0, (size_t)(end - p))
                   ? OST_OK
                   : ost_fail(err, OST_ERR_INPUT, "%s:%lld: a zero byte; expected a line of text", r->path,
                              (long long)r->line);
    bool header = !r->past_header && ost_text_is_header(p, end);
    r->past_header = true;
    return header ? read_header(r, p, end, err) : read_row(r, p, end, err);
}

/* ----------------------------------------------------------------------- gaps */

/* Returns the squared distance between two ticks in pm^2. The distance is below 2^45 on each axis. */
static ost_i128 distance_squared(const ost_tick *a, const ost_tick *b)
{
    const int64_t d[3] = {b->pose.t.x - a->pose.t.x, b->pose.t.y - a->pose.t.y, b->pose.t.z - a->pose.t.z};
    return (ost_i128)d[0] * d[0] + (ost_i128)d[1] * d[1] + (ost_i128)d[2] * d[2];
}

static bool is_pair(const ost_tick *a, const ost_tick *b)
{
    return a->tool == b->tool && !b->lifted;
}

static int ascending(const void *a, const void *b)
{
    const ost_i128 x = *(const ost_i128 *)a, y = *(const ost_i128 *)b;
    return (x > y) - (x < y);
}

/* Computes the median distance, of(a, b), of all pairs of adjacent ticks. There must be at least one pair. */
static ost_status median_of(const reader *r, ost_i128 (*of)(const ost_tick *, const ost_tick *), ost_i128 *out,
                            ost_error *err)
{
    const ost_path *path = r->out;
    ost_i128 *values = malloc(path->count * sizeof *values);
    size_t count = 0;
    if (!values)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the intervals of %zu rows", r->path, path->count);
    for (size_t i = 1; i < path->count; i++)
        if (is_pair(&path->ticks[i - 1], &path->ticks[i]))
            values[count++] = of(&path->ticks[i - 1], &path->ticks[i]);
    qsort(values, count, sizeof *values, ascending);
    *out = values[(count - 1) / 2];
    free(values);
    return OST_OK;
}

static ost_i128 interval(const ost_tick *a, const ost_tick *b)
{
    return b->t_ns - a->t_ns;
}

/*
 * Computes the limit for gaps: two adjacent ticks a and b have a gap if of(a, b), their distance, is above the limit.
 * If `given` is not 0, the limit is `given`. Otherwise, it is the maximum of `least` and factor * median distance; the
 * median is computed only if a distance exceeds `least`.
 */
static ost_status limit_of(const reader *r, ost_i128 (*of)(const ost_tick *, const ost_tick *), ost_i128 given,
                           ost_i128 least, int factor, ost_i128 *out, ost_error *err)
{
    const ost_path *path = r->out;
    bool beyond = false;
    *out = given ? given : least;
    for (size_t i = 1; i < path->count && !given && !beyond; i++)
        beyond = is_pair(&path->ticks[i - 1], &path->ticks[i]) && of(&path->ticks[i - 1], &path->ticks[i]) > least;
    ost_i128 median = 0;
    ost_status status = beyond ? median_of(r, of, &median, err) : OST_OK;
    if (status == OST_OK && factor * median > *out)
        *out = factor * median;
    return status;
}

/*
 * Marks a tick as lifted if it is too far from the previous tick in time or space, and counts the lifted ticks
 * (AR-PATH-5). A median is below 2^93, so its product with TIMES_MEDIAN^2 fits in an ost_i128.
 */
static ost_status mark_gaps(reader *r, const ost_path_options *options, ost_error *err)
{
    const ost_path *path = r->out;
    const int64_t gap = options ? options->max_gap_ns : 0;
    const ost_pm jump = options ? options->max_jump_pm : 0;
    ost_i128 longest = 0, farthest = 0;
    const bool by_time = gap != OST_PATH_NO_GAPS && (gap || !r->lifted_column),
               by_space = jump != OST_PATH_NO_GAPS && (jump || !r->lifted_column);
    ost_status status = by_time ? limit_of(r, interval, gap, GAP_LEAST_NS, TIMES_MEDIAN, &longest, err) : OST_OK;
    if (status == OST_OK && by_space)
        status = limit_of(r, distance_squared, (ost_i128)jump * jump, (ost_i128)JUMP_LEAST_PM * JUMP_LEAST_PM,
                          TIMES_MEDIAN * TIMES_MEDIAN, &farthest, err);
    if (status != OST_OK)
        return status;
    for (size_t i = path->count; i-- > 1;) {
        const ost_tick *a = &path->ticks[i - 1];
        ost_tick *b = &path->ticks[i];
        if (is_pair(a, b))
            b->lifted = (by_time && interval(a, b) > longest) || (by_space && distance_squared(a, b) > farthest);
        r->report.gaps += b->lifted;
    }
    return OST_OK;
}

ost_status ost_path_read(const char *path, const ost_path_options *options, ost_path *out, ost_path_report *report,
                         ost_error *err)
{
    *out = (ost_path){0};
    reader r = {.path = path, .out = out};
    for (int k = 0; k < KINDS; k++)
        r.kind[k] = (uint8_t)(k > TOOL ? NOT_READ : k);
    ost_text_lines *lines;
    ost_status status = ost_text_lines_open(path, &lines, err);
    if (status != OST_OK)
        return status;
    bool packed = false;
    status = ost_text_lines_unpack(lines, &packed, err);
    ost_text_block block = {NULL, NULL};
    do {
        if (status == OST_OK)
            status = ost_text_lines_next(lines, r.line + 1, &block, err);
        const char *p = block.begin;
        r.bytes += block.end - block.begin;
        if (status == OST_OK && packed && r.bytes > UNPACKED_MAX)
            status = ost_fail(err, OST_ERR_RANGE, "%s: unpacks to more than %lld bytes of text", path,
                              (long long)UNPACKED_MAX);
        while (status == OST_OK && p < block.end) {
            const char *newline = memchr(p, '\n', (size_t)(block.end - p));
            status = read_line(&r, p, newline, err);
            p = newline + 1;
        }
    } while (status == OST_OK && block.begin < block.end);
    ost_text_lines_close(lines);
    if (status == OST_OK && r.report.rows == 0)
        status = ost_fail(err, OST_ERR_INPUT, r.line ? "%s: no rows of values; expected %s"
                                                     : "%s: file is empty; expected %s", path, expected_row);
    if (status == OST_OK && out->count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: no row has a pose; rows with nan in a column of the pose: %zu",
                          path, r.report.rows);
    if (status == OST_OK)
        status = mark_gaps(&r, options, err);
    if (status != OST_OK)
        ost_path_free(out);
    else if (report)
        *report = r.report;
    return status;
}

ost_status ost_path_read_csv(const char *path, ost_path *out, ost_error *err)
{
    return ost_path_read(path, NULL, out, NULL, err);
}

/* -------------------------------------------------------------------- writing */

enum { NUMBER = 40 };

/* Formats value / 10^places without trailing zeros. Requires 0 <= places <= 18. */
static const char *format_scaled(int64_t value, int places, char text[NUMBER])
{
    uint64_t remainder = value < 0 ? -(uint64_t)value : (uint64_t)value;
    char digits[NUMBER];
    int at = NUMBER;
    digits[--at] = 0;
    bool significant = false;
    for (int i = 0; i < places; i++, remainder /= 10) {
        if (remainder % 10 == 0 && !significant)
            continue;
        significant = true;
        digits[--at] = (char)('0' + remainder % 10);
    }
    if (significant)
        digits[--at] = '.';
    do {
        digits[--at] = (char)('0' + remainder % 10);
        remainder /= 10;
    } while (remainder > 0);
    if (value < 0)
        digits[--at] = '-';
    memcpy(text, digits + at, (size_t)(NUMBER - at));
    return text;
}

/* Formats a quaternion component with ten decimals. |q| < 2^31, so the product is below 2^65 and requires 128 bits. */
static const char *format_component(int32_t q, char text[NUMBER])
{
    return format_scaled((int64_t)ost_rhe_div128((ost_i128)q * INT64_C(10000000000), OST_Q30_ONE), 10, text);
}

ost_status ost_path_put_tick(ost_outfile *out, const ost_tick *tick, bool tools, ost_error *err)
{
    char n[8][NUMBER];
    const ost_pose *p = &tick->pose;
    ost_status status = ost_outfile_printf(
        out, err, "%s,%s,%s,%s,%s,%s,%s,%s", format_scaled(tick->t_ns, 9, n[0]), format_scaled(p->t.x, 9, n[1]),
        format_scaled(p->t.y, 9, n[2]), format_scaled(p->t.z, 9, n[3]), format_component(p->qw, n[4]),
        format_component(p->qx, n[5]), format_component(p->qy, n[6]), format_component(p->qz, n[7]));
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
    /*
     * Because the text has the column `lifted`, a reader marks no gaps and obtains exactly the ticks that were written
     * (AR-PATH-5).
     */
    status = ost_outfile_printf(out, err, "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz%s,lifted,rpm\n", tools ? ",tool" : "");
    for (size_t i = 0; i < in->count && status == OST_OK; i++) {
        status = ost_path_put_tick(out, &in->ticks[i], tools, err);
        if (status == OST_OK)
            status = ost_outfile_printf(out, err, ",%d,%" PRId32 "\n", in->ticks[i].lifted, in->ticks[i].rpm);
    }
    if (status == OST_OK)
        return ost_outfile_commit(out, err);
    ost_outfile_discard(out);
    return status;
}
