/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Text for people: the summary on standard output (not with --json or --quiet), warnings on
 * standard error (not with --quiet), and formatted numbers.
 */
#ifndef OST_APP_SAY_H
#define OST_APP_SAY_H

#include "app/app.h"

void say(const app_state *app, const char *format, ...) OST_PRINTF(2, 3);
/* Prints one line on a stream, whether or not the verb is quiet. Characters that are not printable
   become '?' (core/printable.h). */
void say_on(FILE *to, const char *format, ...) OST_PRINTF(2, 3);
/* Prints a JSON document; characters that act on a terminal are escaped as \uXXXX. */
void say_json(const char *text);
void warn(const app_state *app, const char *format, ...) OST_PRINTF(2, 3);

enum { SAY_TEXT = 96 };
/* Formats a count: "1,234,567". */
const char *say_count(char text[SAY_TEXT], int64_t value);
/* Formats dimensions: "256 x 234 x 201". */
const char *say_dims(char text[SAY_TEXT], ost_dims dims);
/* Formats spacings: "0.47 x 0.47 x 1 mm", or "0.47 mm" if all are equal. */
const char *say_spacing(char text[SAY_TEXT], ost_pm3 spacing);
/* Formats a point: "(-117.8, 196.5, -159) mm". */
const char *say_point(char text[SAY_TEXT], ost_pm3 point);
/* Formats a size: "12 bytes", "3.4 MB". */
const char *say_bytes(char text[SAY_TEXT], int64_t bytes);
/* Formats a duration: "12.3 ms", "4.5 s". */
const char *say_time(char text[SAY_TEXT], double ms);

#endif
