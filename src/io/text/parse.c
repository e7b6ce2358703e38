/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/text/parse.h"

#include <string.h>

enum { COLUMNS = 4, POSITION_MAX = 8000 };
_Static_assert(POSITION_MAX * OST_PM_PER_MM == OST_LENGTH_MAX, "positions are lengths");
static const char zero_byte[] = "a zero byte; expected a line of text: x y z density";
static const char *const column_names[COLUMNS] = {"x", "y", "z", "density"};

static const int64_t power_of_ten[10] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000, 1000000000};

/* ------------------------------------------------------------------ errors */

static ost_status fail_line(const ost_text_parser *parser, const char *text, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %s", parser->path, (long long)parser->line, text);
}

static ost_status fail_field(const ost_text_parser *parser, int column, const char *field, const char *end,
                             const char *expected, ost_error *err)
{
    char quote[OST_TEXT_QUOTE];
    const char *field_end = ost_text_field_end(field, end);
    if (ost_text_is_binary(field, field_end))
        return fail_line(parser, "binary bytes; expected a line of text: x y z density", err);
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: column %d (%s) is '%s'; expected %s", parser->path,
                    (long long)parser->line, column + 1, column_names[column], ost_text_quote(field, field_end, quote),
                    expected);
}

/*
 * Reports a line that does not have four columns, and states the number of its columns. Decimal commas turn four
 * columns into eight; in this case, the message mentions decimal commas.
 */
static ost_status fail_count(const ost_text_parser *parser, const char *begin, const char *end, ost_error *err)
{
    const char *p = begin;
    int count = 0;
    for (;; count++) {
        ost_text_field_kind kind = ost_text_field_start(&p, end, count);
        if (kind == OST_TEXT_EMPTY)
            return ost_fail(err, OST_ERR_INPUT, "%s:%lld: value %d is empty; expected 4 values: x y z density",
                            parser->path, (long long)parser->line, count + 1);
        if (kind == OST_TEXT_END)
            break;
        p = ost_text_field_end(p, end);
    }
    return ost_fail(err, OST_ERR_INPUT, "%s:%lld: %d value%s; expected 4: x y z density%s", parser->path,
                    (long long)parser->line, count, count == 1 ? "" : "s",
                    count > COLUMNS && memchr(begin, ',', (size_t)(end - begin))
                        ? " (the decimal sign is a point, not a comma)"
                        : "");
}

/* ------------------------------------------------------------------- values */

/*
 * Equivalent to ost_decimal_to_pm, but needs only one multiplication in most cases. The position is mantissa * 10^shift
 * pm, so it is within +-8000 mm iff |mantissa| <= 8000 * 10^(9 - shift).
 */
static bool to_pm(const ost_decimal *value, ost_pm *out, bool *exact)
{
    int shift = 9 + value->exponent;
    if (shift >= 0 && shift <= 9 && !value->inexact) {
        int64_t factor = power_of_ten[shift], limit = POSITION_MAX * power_of_ten[9 - shift];
        *exact = true;
        bool in_range = value->mantissa >= -limit && value->mantissa <= limit;
        *out = in_range ? value->mantissa * factor : 0;
        return in_range;
    }
    return ost_decimal_to_pm(value, out, exact);
}

static ost_status parse_position(const ost_text_parser *parser, int column, const char *field, const char *end,
                                 const ost_decimal *value, ost_text_row *row, ost_error *err)
{
    bool exact;
    if (!to_pm(value, &row->position[column], &exact))
        return fail_field(parser, column, field, end, "a position within 8000 mm of 0", err);
    row->rounded |= (uint8_t)(!exact << column);
    int places = value->places;
    places = places > OST_TEXT_PLACES_MAX ? OST_TEXT_PLACES_MAX : places;
    row->places[column] = (int8_t)(places < OST_TEXT_PLACES_MIN ? OST_TEXT_PLACES_MIN : places);
    return OST_OK;
}

static ost_status parse_density(const ost_text_parser *parser, int column, const char *field, const char *end,
                                const ost_decimal *value, ost_text_row *row, ost_error *err)
{
    int64_t density = value->mantissa;
    bool exact = value->exponent == 0 && !value->inexact;
    if (!exact && !ost_decimal_scale(value, 1, &density, &exact))
        return fail_field(parser, column, field, end, "a density from -32768 to 32767", err);
    if (density < INT16_MIN || density > INT16_MAX)
        return fail_field(parser, column, field, end, "a density from -32768 to 32767", err);
    if (!exact)
        return fail_field(parser, column, field, end, "a density without decimals", err);
    row->density = (int32_t)density;
    return OST_OK;
}

/* -------------------------------------------------------------------- lines */

/* Parses a sample. `p` is the start of the first field, and `end` is the end of the line. */
static ost_status parse_row(const ost_text_parser *parser, const char *p, const char *end, ost_text_row *row,
                            ost_error *err)
{
    const char *begin = p;
    row->line = parser->line;
    row->rounded = 0;
    for (int column = 0; column < COLUMNS; column++) {
        if (ost_text_field_start(&p, end, column) != OST_TEXT_FIELD)
            return fail_count(parser, begin, end, err);
        const char *field = p;
        ost_decimal value;
        p = ost_decimal_read(p, end, &value);
        if (!p || (p < end && !ost_text_ends_field(*p)))
            return fail_field(parser, column, field, end, "a decimal number", err);
        ost_status status = column < 3 ? parse_position(parser, column, field, end, &value, row, err)
                                       : parse_density(parser, column, field, end, &value, row, err);
        if (status != OST_OK)
            return status;
    }
    if (ost_text_field_start(&p, end, COLUMNS) != OST_TEXT_END)
        return fail_count(parser, begin, end, err);
    return p == end || !memchr(p, 0, (size_t)(end - p)) ? OST_OK : fail_line(parser, zero_byte, err);
}

/*
 * Processes a line that contains no sample: an empty line, a comment or the header. For any other line, sets *is_row to
 * true.
 */
static ost_status parse_other(ost_text_parser *parser, const char *p, const char *end, bool *is_row, ost_error *err)
{
    *is_row = false;
    if (p == end)
        return OST_OK;
    if (*p == '#') {
        ost_text_fact fact;
        if (memchr(p, 0, (size_t)(end - p)))
            return fail_line(parser, zero_byte, err);
        return parser->fact && ost_text_fact_read(p, end, &fact) ? parser->fact(parser->user, parser, &fact, err)
                                                                 : OST_OK;
    }
    *is_row = parser->past_header || !ost_text_is_header(p, end);
    parser->past_header = true;
    return OST_OK;
}

ost_status ost_text_parse(ost_text_parser *parser, ost_text_block *block, ost_text_row *rows, size_t capacity,
                          size_t *count, ost_error *err)
{
    ost_status status = OST_OK;
    size_t filled = 0;
    const char *p = block->begin;
    while (p < block->end && filled < capacity && status == OST_OK) {
        const char *newline = memchr(p, '\n', (size_t)(block->end - p));
        const char *end = newline > p && newline[-1] == '\r' ? newline - 1 : newline;
        parser->line++;
        if (newline - p > OST_TEXT_LINE_MAX) {
            status = ost_fail(err, OST_ERR_INPUT, "%s:%lld: the line is longer than %d bytes; expected a text file",
                              parser->path, (long long)parser->line, OST_TEXT_LINE_MAX);
            break;
        }
        p = ost_text_skip_blanks(p, end);
        bool is_row = true;
        if (p == end || *p == '#' || !parser->past_header)
            status = parse_other(parser, p, end, &is_row, err);
        if (is_row && status == OST_OK) {
            status = parse_row(parser, p, end, &rows[filled], err);
            filled += status == OST_OK;
        }
        p = newline + 1;
    }
    block->begin = p;
    *count = filled;
    return status;
}
