/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/print.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/progress.h"
#include "app/common/result.h"
#include "core/printable.h"

enum { LINE = 4096 };

static void write_line(FILE *to, const char *before, json_t *record, const char *format, va_list args)
    OST_PRINTF(4, 0);

/*
 * If `to` is not NULL, prints one line. If `record` is not NULL, appends the line to the array `record`. Every
 * character that is not printable, including newlines, is replaced by '?'. Memory is allocated only if the line has
 * more than LINE bytes.
 */
static void write_line(FILE *to, const char *before, json_t *record, const char *format, va_list args)
{
    char line[LINE], *text = line;
    va_list again;
    va_copy(again, args);
    const int length = vsnprintf(line, sizeof line, format, args);
    if (length >= LINE && (text = malloc((size_t)length + 1)))
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    if (length < 0 || !text) {
        fputs("osteon: no memory for a line of text\n", stderr);
        exit(2);
    }
    ost_make_printable(text);
    if (to)
        fprintf(to, "%s%s\n", before, text);
    if (record)
        append(record, json_string_nocheck(text));
    if (text != line)
        free(text);
}

void print_line(const app_state *app, const char *format, ...)
{
    if (app->json || app->quiet || app->to_stdout)
        return;
    progress_clear();
    va_list args;
    va_start(args, format);
    write_line(stdout, "", NULL, format, args);
    va_end(args);
}

void warn(const app_state *app, const char *format, ...)
{
    progress_clear();
    char before[64];
    va_list args;
    va_start(args, format);
    snprintf(before, sizeof before, "osteon %s: warning: ", app->verb);
    write_line(app->quiet ? NULL : stderr, before, app->warnings, format, args);
    va_end(args);
}

void print_line_to(FILE *to, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    write_line(to, "", NULL, format, args);
    va_end(args);
}

void print_json(const char *text)
{
    for (size_t bytes; *text; text += bytes) {
        const int32_t code = ost_code_point(text, &bytes);
        if (code == '\n' || ost_code_point_is_printable(code))
            fwrite(text, 1, bytes, stdout);
        else
            /* unprintable characters occur only within strings, where JSON allows escape sequences */
            printf("\\u%04x", (unsigned)(code < 0 ? 0xfffd : code));
    }
    putchar('\n');
}

const char *format_count(char text[FORMAT_TEXT], int64_t value)
{
    char digits[24];
    int n = snprintf(digits, sizeof digits, "%" PRId64, value);
    char *to = text;
    for (int i = 0; i < n; i++) {
        *to++ = digits[i];
        int left = n - 1 - i;
        if (left && left % 3 == 0 && digits[i] != '-')
            *to++ = ',';
    }
    *to = '\0';
    return text;
}

const char *format_dims(char text[FORMAT_TEXT], ost_dims dims)
{
    snprintf(text, FORMAT_TEXT, "%d x %d x %d", dims.x, dims.y, dims.z);
    return text;
}

const char *format_spacing(char text[FORMAT_TEXT], ost_pm3 s)
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    if (s.x == s.y && s.y == s.z)
        snprintf(text, FORMAT_TEXT, "%s mm", ost_pm_format(s.x, x));
    else
        snprintf(text, FORMAT_TEXT, "%s x %s x %s mm", ost_pm_format(s.x, x), ost_pm_format(s.y, y),
                 ost_pm_format(s.z, z));
    return text;
}

const char *format_point(char text[FORMAT_TEXT], ost_pm3 p)
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    snprintf(text, FORMAT_TEXT, "(%s, %s, %s) mm", ost_pm_format(p.x, x), ost_pm_format(p.y, y), ost_pm_format(p.z, z));
    return text;
}

const char *format_bytes(char text[FORMAT_TEXT], int64_t bytes)
{
    static const char *const unit[] = {"kB", "MB", "GB", "TB"};
    if (bytes < 1000) {
        snprintf(text, FORMAT_TEXT, "%d bytes", (int)bytes);
        return text;
    }
    double value = (double)bytes / 1000;
    int u = 0;
    for (; value >= 999.5 && u < 3; u++)
        value /= 1000;
    snprintf(text, FORMAT_TEXT, "%.3g %s", value, unit[u]);
    return text;
}

const char *format_time(char text[FORMAT_TEXT], double ms)
{
    if (ms < 1000)
        snprintf(text, FORMAT_TEXT, "%.3g ms", ms);
    else
        snprintf(text, FORMAT_TEXT, "%.1f s", ms / 1000);
    return text;
}
