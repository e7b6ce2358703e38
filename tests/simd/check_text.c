/* SPDX-License-Identifier: Apache-2.0 */
/*
 * text_newlines, text_match.
 *
 * Lines that match come with one somewhere that does not, in one way of many:
 * a byte changed, missing or added, a density out of range, of six digits, of
 * none, with a sign or a letter, a line of nothing.
 */
#include <stdio.h>
#include <string.h>

#include "io/text/match.h"
#include "simd/check.h"

/* ----------------------------------------------------------------- newlines */

typedef struct newlines_arguments {
    const char *text;
    size_t bytes;
    uint32_t base;
    uint32_t *at;
    size_t count;
} newlines_arguments;

static void call_newlines(check_fn *kernel, void *with)
{
    newlines_arguments *a = with;
    a->count = ((ost_text_newlines *)kernel)(a->text, a->bytes, a->base, a->at);
}

static void test_newlines(check *c)
{
    const size_t bytes = 64 * (size_t)(c->number < 40 ? c->number % 20 : check_range(c, 0, 40));
    char *text = check_input(c, "text", bytes, 1, 1);
    static const int rare[] = {1, 2, 10, 40, 100000};
    const int one_in = rare[check_range(c, 0, 4)];
    for (size_t i = 0; i < bytes; i++)
        text[i] = check_chance(c, one_in) ? '\n' : check_chance(c, 3) ? (char)('\n' + check_range(c, -1, 1) * 128) : (char)rng_next(&c->rng);
    const uint32_t base = check_chance(c, 2) ? OST_TEXT_MARGIN : (uint32_t)check_range(c, 0, (INT64_C(1) << 31) - 1 - (int64_t)bytes);
    void *at[2];
    check_outputs(c, "at", bytes + 8, sizeof(uint32_t), sizeof(uint32_t), at);
    check_note(c, "%zu bytes, a newline in about %d, base %u", bytes, one_in, base);
    newlines_arguments a = {text, bytes, base, at[0], 0}, b = {text, bytes, base, at[1], 0};
    if (check_both(c, call_newlines, &a, &b) && check_that(c, a.count == b.count, "returns %zu, not %zu", b.count, a.count))
        check_same(c, "at", CHECK_U32, at[0], at[1], a.count);
}

static void bench_newlines(check_bench *b)
{
    static char text[1 << 14];
    static uint32_t at[(1 << 14) + 8];
    memset(text, '7', sizeof text);
    for (size_t i = 34; i < sizeof text; i += 34 + i % 3)
        text[i] = '\n';
    newlines_arguments a = {text, sizeof text, OST_TEXT_MARGIN, at, 0};
    bench_time(b, "16384 bytes, lines of 35", call_newlines, NULL, &a, sizeof text, "byte");
}

/* -------------------------------------------------------------------- match */

typedef struct match_arguments {
    const ost_text_pattern *pattern;
    const ost_text_column *columns;
    const uint8_t *lengths;
    const char *text;
    const uint32_t *ends; /* ends[-1] is there */
    size_t lines;
    int16_t *density;
    size_t matched;
} match_arguments;

static void call_match(check_fn *kernel, void *with)
{
    match_arguments *a = with;
    a->matched = ((ost_text_match *)kernel)(a->pattern, a->columns, a->lengths, a->text, a->ends, a->lines, a->density);
}

enum { LINES_MAX = 70, LINE_MAX = 2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX + 24 };

static char some_byte(check *c)
{
    static const char usual[] = "0123456789.- \t,e+";
    return check_chance(c, 20) ? (char)check_range(c, 11, 255) : usual[check_range(c, 0, (int64_t)sizeof usual - 2)];
}

static void some_bytes(check *c, size_t length, unsigned char *text, unsigned char *mask, size_t room)
{
    memset(text, 0, room);
    memset(mask, 0, room);
    for (size_t i = 0; i < length; i++) {
        text[i] = (unsigned char)some_byte(c);
        mask[i] = 0xff;
    }
}

/* Text of a density; good says whether it is one. */
static size_t some_density(check *c, bool good, char *out)
{
    static const char *const fine[] = {"0", "-0", "1", "-1", "9", "10", "32767", "-32768", "32766", "-32767", "00000", "-00000", "00123", "-00009", "12345", "-1024", "1043"};
    static const char *const foul[] = {"",       "-",      "32768",  "-32769", "99999",  "-99999", "65536",  "100000", "-100000", "000001", "-000001",
                                       "1234567", "12345678", "123456789", "--1",    "+1",     "1-",     "1.0",    "1e3",    "/",      ":",       "1/2",
                                       "1:2",    " 1",     "1 ",     "0x1",    "\xb0",  "1\xb9",  "12\xff\x30", "-\x80", "3\xba", "1\t",   "a",       "1\r"};
    if (!good)
        strcpy(out, foul[check_range(c, 0, sizeof foul / sizeof foul[0] - 1)]);
    else if (check_chance(c, 3))
        strcpy(out, fine[check_range(c, 0, sizeof fine / sizeof fine[0] - 1)]);
    else
        snprintf(out, 8, "%d", (int)(check_chance(c, 2) ? check_range(c, -32768, 32767) : check_range(c, -1200, 3000)));
    return strlen(out);
}

/* One line without its newline. */
static size_t some_line(check *c, const ost_text_pattern *p, const ost_text_column *column, size_t column_length, bool good, char *out)
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
    if (way == 2 && n > 0) { /* another byte */
        out[at] = (char)(out[at] ^ (1 << check_range(c, 0, 7)));
        out[at] = out[at] == '\n' ? 'n' : out[at];
    } else if (way == 3 && n > 0) { /* one less */
        memmove(out + at, out + at + 1, n - at - 1);
        n--;
    } else if (way == 4) { /* one more */
        memmove(out + at + 1, out + at, n - at);
        out[at] = some_byte(c);
        n++;
    } else if (way == 5) { /* its beginning only */
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
    some_bytes(c, pattern->before.length, pattern->before.text, pattern->before.mask, OST_TEXT_AROUND_MAX);
    some_bytes(c, pattern->after.length, pattern->after.text, pattern->after.mask, OST_TEXT_AROUND_MAX);
    ost_text_column *columns = check_input(c, "columns", lines, sizeof *columns, 1);
    uint8_t *lengths = check_input(c, "lengths", lines, 1, 1);
    uint32_t *ends = (uint32_t *)check_input(c, "ends", lines + 1, sizeof *ends, sizeof *ends) + 1;
    static char joined[LINES_MAX * LINE_MAX];
    size_t bytes = 0;
    /* Where the first line begins: as the walker has it, or far from there. */
    const uint32_t base = check_chance(c, 2) ? OST_TEXT_MARGIN : (uint32_t)check_range(c, 1, (INT64_C(1) << 31) - 1 - (int64_t)sizeof joined);
    ends[-1] = base - 1;
    const int one_bad_in = (int)check_range(c, 1, 60);
    for (size_t i = 0; i < lines; i++) {
        lengths[i] = (uint8_t)check_range(c, 0, OST_TEXT_COLUMN_MAX);
        some_bytes(c, lengths[i], columns[i].text, columns[i].mask, OST_TEXT_COLUMN_MAX);
        bytes += some_line(c, pattern, &columns[i], lengths[i], !check_chance(c, one_bad_in), joined + bytes);
        ends[i] = base + (uint32_t)bytes;
        joined[bytes++] = '\n';
    }
    char *text = check_input(c, "text with its margins", bytes + 2 * OST_TEXT_MARGIN, 1, 1);
    memset(text, '5', bytes + 2 * OST_TEXT_MARGIN); /* what is like a density, so that who looks there takes it for one */
    memcpy(text + OST_TEXT_MARGIN, joined, bytes);
    void *density[2];
    check_outputs(c, "density", lines, sizeof(int16_t), sizeof(int16_t), density);
    check_note(c, "%zu lines, %u bytes before, %u after, carriage %d", lines, pattern->before.length, pattern->after.length, pattern->carriage);
    const char *origin = (const char *)((uintptr_t)text + OST_TEXT_MARGIN - base); /* the walker's text begins a margin earlier */
    match_arguments a = {pattern, columns, lengths, origin, ends, lines, density[0], 0}, b = a;
    b.density = density[1];
    if (check_both(c, call_match, &a, &b) && check_that(c, a.matched == b.matched, "matches %zu, not %zu", b.matched, a.matched))
        check_same(c, "density", CHECK_I16, density[0], density[1], a.matched);
}

static void bench_match(check_bench *b)
{
    enum { LINES = 256 };
    static ost_text_pattern pattern;
    static ost_text_column columns[LINES];
    static uint8_t lengths[LINES];
    static uint32_t ends[LINES + 1];
    static char text[2 * OST_TEXT_MARGIN + 64 * LINES];
    static int16_t density[LINES];
    size_t bytes = OST_TEXT_MARGIN;
    strcpy((char *)pattern.after.text, " 12.220000 3.000000 ");
    pattern.after.length = (uint32_t)strlen((char *)pattern.after.text);
    memset(pattern.after.mask, 0xff, pattern.after.length);
    ends[0] = OST_TEXT_MARGIN - 1;
    for (size_t i = 0; i < LINES; i++) {
        lengths[i] = (uint8_t)snprintf((char *)columns[i].text, sizeof columns[i].text, "%.6f", -57.34 + 0.47 * (double)i);
        memset(columns[i].mask, 0xff, lengths[i]);
        bytes += (size_t)snprintf(text + bytes, 64, "%s%s%d", (char *)columns[i].text, (char *)pattern.after.text, (int)(i * 37 % 1500) - 200);
        ends[i + 1] = (uint32_t)bytes;
        text[bytes++] = '\n';
    }
    match_arguments a = {&pattern, columns, lengths, text, ends + 1, LINES, density, 0};
    bench_time(b, "256 lines of 34 bytes", call_match, NULL, &a, LINES, "line");
}

static check_fn *newlines_of(ost_isa isa)
{
    ost_text_kernels kernels;
    ost_text_kernels_fill(&kernels, isa);
    return (check_fn *)kernels.newlines;
}

static check_fn *match_of(ost_isa isa)
{
    ost_text_kernels kernels;
    ost_text_kernels_fill(&kernels, isa);
    return (check_fn *)kernels.match;
}

extern const check_kernel check_text_newlines, check_text_match;
const check_kernel check_text_newlines = {
    .name = "text_newlines", .of = newlines_of, .test = test_newlines, .bench = bench_newlines, .cases = 400};
const check_kernel check_text_match = {.name = "text_match", .of = match_of, .test = test_match, .bench = bench_match, .cases = 2500};
