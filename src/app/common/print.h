/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints human-readable text and formats numbers. The summary is printed on standard output, unless --json or --quiet
 * is given or the output file is standard output. Warnings are printed on standard error, unless --quiet is given.
 */
#ifndef OST_APP_COMMON_PRINT_H
#define OST_APP_COMMON_PRINT_H

#include "app/common/app.h"

void print_line(const app_state *app, const char *format, ...) OST_PRINTF(2, 3);
/*
 * Prints one line to a stream, even if --quiet is given. Characters that are not printable are replaced by '?'
 * (core/printable.h).
 */
void print_line_to(FILE *to, const char *format, ...) OST_PRINTF(2, 3);
/* Prints a JSON document. Characters that could control a terminal are escaped as \uXXXX. */
void print_json(const char *text);
void warn(const app_state *app, const char *format, ...) OST_PRINTF(2, 3);

enum { FORMAT_TEXT = 96 };
/* Formats a count: "1,234,567". */
const char *format_count(char text[FORMAT_TEXT], int64_t value);
/* Formats dimensions: "256 x 234 x 201". */
const char *format_dims(char text[FORMAT_TEXT], ost_dims dims);
/* Formats spacings: "0.47 x 0.47 x 1 mm", or "0.47 mm" if all are equal. */
const char *format_spacing(char text[FORMAT_TEXT], ost_pm3 spacing);
/* Formats a point: "(-117.8, 196.5, -159) mm". */
const char *format_point(char text[FORMAT_TEXT], ost_pm3 point);
/* Formats a size: "12 bytes", "3.4 MB". */
const char *format_bytes(char text[FORMAT_TEXT], int64_t bytes);
/* Formats a duration: "12.3 ms", "4.5 s". */
const char *format_time(char text[FORMAT_TEXT], double ms);

#endif
