/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernel text_match.
 *
 * In most texts, lines that match are followed by a line that does not match. This line has one of the
 * following defects:
 *
 *   - a byte is changed, missing or added
 *   - the density is out of range, or has more than five digits, no digits, a wrong sign or another character
 *   - the carriage return is missing or superfluous
 *   - only the beginning of the line is present, or the line is empty
 *
 * In some cases, the text continues after `end`. A kernel must not match the lines there.
 */
#include <stdio.h>
#include <string.h>

#include "io/text/match.h"
#include "simd/check.h"

typedef struct match_arguments {
    const ost_text_pattern *pattern;
    const ost_text_column *columns;
    const uint8_t *lengths;
    const char *text, *end;
    size_t lines;
    int16_t *density;
    size_t matched;
    const char *next;
} match_arguments;

static void call_match(check_fn *kernel, void *with)
{
    match_arguments *a = with;
    a->matched = ((ost_text_match *)kernel)(a->pattern, a->columns, a->lengths, a->text, a->end, a->lines, a->density,
                                            &a->next);
}

enum { LINES_MAX = 70, LINE_MAX = 2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX + 24 };

static char some_byte(check *c)
{
    static const char usual[] = "0123456789.- \t,e+";
    return check_chance(c, 20) ? (char)check_range(c, 11, 255) : usual[check_range(c, 0, (int64_t)sizeof usual - 2)];
}

static void some_bytes(check *c, size_t length, unsigned char *text, unsigned char *mask, size_t capacity)
{
    memset(text, 0, capacity);
    memset(mask, 0, capacity);
    for (size_t i = 0; i < length; i++) {
        text[i] = (unsigned char)some_byte(c);
        mask[i] = 0xff;
    }
}

/* Writes a valid text of a density if `good` is true, and an invalid text otherwise. Returns the text's length. */
static size_t some_density(check *c, bool good, char *out)
{
    static const char *const fine[] = {"0",     "-0",     "1",     "-1",     "9",     "10",
                                       "32767", "-32768", "32766", "-32767", "00000", "-00000",
                                       "00123", "-00009", "12345", "-1024",  "1043"};
    static const char *const foul[] = {"",           "-",       "32768",  "-32769",  "99999",   "-99999",   "65536",
                                       "100000",     "-100000", "000001", "-000001", "1234567", "12345678", "123456789",
                                       "--1",        "+1",      "1-",     "1.0",     "1e3",     "/",        ":",
                                       "1/2",        "1:2",     " 1",     "1 ",      "0x1",     "\xb0",     "1\xb9",
                                       "12\xff\x30", "-\x80",   "3\xba",  "1\t",     "a",       "1\r"};
    if (!good)
        strcpy(out, foul[check_range(c, 0, sizeof foul / sizeof foul[0] - 1)]);
    else if (check_chance(c, 3))
        strcpy(out, fine[check_range(c, 0, sizeof fine / sizeof fine[0] - 1)]);
    else
        snprintf(out, 8, "%d", (int)(check_chance(c, 2) ? check_range(c, -32768, 32767) : check_range(c, -1200, 3000)));
    return strlen(out);
}

/* Writes one line without its newline. Returns its length. */
static size_t some_line(check *c, const ost_text_pattern *p, const ost_text_column *column, size_t column_length,
                        bool good, char *out)
{
    size_t n = 0;
    memcpy(out, p->before.text, p->before.length);
    n += p->before.length;
    memcpy(out + n, column->text, column_length);
    n += column_length;
    memcpy(out + n, p->after.text, p->after.length);
    n += p->after.length;
    const int way = good ? -1 : (int)check_range(c, 0, 5);
    char density[24];
    const size_t digits = some_density(c, way != 0, density);
    memcpy(out + n, density, digits);
    n += digits;
    if (p->carriage && way != 1)
        out[n++] = '\r';
    else if (!p->carriage && way == 1)
        out[n++] = '\r';
    const size_t at = n > 0 ? (size_t)check_range(c, 0, (int64_t)n - 1) : 0;
    if (way == 2 && n > 0) { /* A byte is changed. */
        out[at] = (char)(out[at] ^ (1 << check_range(c, 0, 7)));
        out[at] = out[at] == '\n' ? 'n' : out[at];
    } else if (way == 3 && n > 0) { /* A byte is missing. */
        memmove(out + at, out + at + 1, n - at - 1);
        n--;
    } else if (way == 4) { /* A byte is added. */
        memmove(out + at + 1, out + at, n - at);
        out[at] = some_byte(c);
        n++;
    } else if (way == 5) { /* Only the beginning of the line is written. */
        n = check_chance(c, 3) ? 0 : at;
    }
    return n;
}

static void test_match(check *c)
{
    const size_t lines = c->number < 80 ? (size_t)c->number % 40 : (size_t)check_range(c, 0, LINES_MAX);
    ost_text_pattern *pattern = check_input(c, "pattern", 1, sizeof *pattern, _Alignof(ost_text_pattern));
    memset(pattern, 0, sizeof *pattern);
    pattern->before.length = check_chance(c, 2) ? 0 : (uint32_t)check_range(c, 0, OST_TEXT_AROUND_MAX);
    pattern->after.length = check_chance(c, 4) ? OST_TEXT_AROUND_MAX : (uint32_t)check_range(c, 0, OST_TEXT_AROUND_MAX);
    pattern->carriage = check_chance(c, 3);
    pattern->shortest = check_chance(c, 2) ? 0 : (uint32_t)check_range(c, 0, OST_TEXT_COLUMN_MAX);
    some_bytes(c, pattern->before.length, pattern->before.text, pattern->before.mask, OST_TEXT_AROUND_MAX);
    some_bytes(c, pattern->after.length, pattern->after.text, pattern->after.mask, OST_TEXT_AROUND_MAX);
    ost_text_column *columns = check_input(c, "columns", lines, sizeof *columns, 1);
    uint8_t *lengths = check_input(c, "lengths", lines, 1, 1);
    static char joined[LINES_MAX * LINE_MAX];
    size_t bytes = 0, begins[LINES_MAX + 1];
    const int one_bad_in = (int)check_range(c, 1, 60);
    for (size_t i = 0; i < lines; i++) {
        lengths[i] = (uint8_t)check_range(c, pattern->shortest, OST_TEXT_COLUMN_MAX);
        some_bytes(c, lengths[i], columns[i].text, columns[i].mask, OST_TEXT_COLUMN_MAX);
        begins[i] = bytes;
        bytes += some_line(c, pattern, &columns[i], lengths[i], !check_chance(c, one_bad_in), joined + bytes);
        joined[bytes++] = '\n';
    }
    begins[lines] = bytes;
    const size_t here = check_chance(c, 3) ? (size_t)check_range(c, 0, (int64_t)lines) : lines, end = begins[here];
    const size_t there = bytes - end < OST_TEXT_MARGIN ? bytes - end : OST_TEXT_MARGIN;
    char *text = check_input(c, "text with its margin", end + OST_TEXT_MARGIN, 1, 1);
    /* The margin after the text contains digits or newlines, so that a kernel that uses it returns a wrong
       result. */
    memset(text, check_chance(c, 3) ? '\n' : '5', end + OST_TEXT_MARGIN);
    memcpy(text, joined, end + there);
    void *density[2];
    check_outputs(c, "density", lines, sizeof(int16_t), sizeof(int16_t), density);
    check_note(c, "%zu lines of %zu, %u bytes before, %u or more of a column, %u after, carriage %d", here, lines,
               pattern->before.length, pattern->shortest, pattern->after.length, pattern->carriage);
    match_arguments a = {pattern, columns, lengths, text, text + end, lines, density[0], 0, NULL}, b = a;
    b.density = density[1];
    if (check_both(c, call_match, &a, &b) &&
        check_that(c, a.matched == b.matched, "the kernel matches %zu lines, expected %zu", b.matched, a.matched) &&
        check_that(c, a.next == b.next, "the kernel ends at byte %td, expected %td", b.next - text, a.next - text) &&
        check_that(c, a.next == text + begins[a.matched], "both kernels end at byte %td, expected %zu", a.next - text,
                   begins[a.matched]))
        check_same(c, "density", CHECK_I16, density[0], density[1], lines); /* includes the poison after the matches */
}

static void bench_match(check_bench *b)
{
    enum { LINES = 256 };
    static ost_text_pattern pattern;
    static ost_text_column columns[LINES];
    static uint8_t lengths[LINES];
    static char text[OST_TEXT_MARGIN + 64 * LINES];
    static int16_t density[LINES];
    size_t bytes = 0;
    strcpy((char *)pattern.after.text, " 12.220000 3.000000 ");
    pattern.after.length = (uint32_t)strlen((char *)pattern.after.text);
    memset(pattern.after.mask, 0xff, pattern.after.length);
    for (size_t i = 0; i < LINES; i++) {
        lengths[i] = (uint8_t)snprintf((char *)columns[i].text, sizeof columns[i].text, "%.6f",
                                       -57.34 + 0.47 * (double)i);
        memset(columns[i].mask, 0xff, lengths[i]);
        pattern.shortest = i == 0 || lengths[i] < pattern.shortest ? lengths[i] : pattern.shortest;
        bytes += (size_t)snprintf(text + bytes, 64, "%s%s%d", (char *)columns[i].text, (char *)pattern.after.text,
                                  (int)(i * 37 % 1500) - 200);
        text[bytes++] = '\n';
    }
    match_arguments a = {&pattern, columns, lengths, text, text + bytes, LINES, density, 0, NULL};
    bench_time(b, "256 lines of 34 bytes", call_match, NULL, &a, LINES, "line");
}

static check_fn *match_of(ost_isa isa)
{
    return (check_fn *)ost_text_match_for(isa);
}

extern const check_kernel check_text_match;
const check_kernel check_text_match = {
    .name = "text_match", .of = match_of, .test = test_match, .bench = bench_match, .cases = 2500};
