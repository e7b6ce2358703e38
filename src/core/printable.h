/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Text from files, file names and devices, made safe for a terminal.
 *
 * A name may hold bytes that move the cursor, change colours, answer a query
 * or turn the direction of the text, so that a message shows what was never
 * printed.  These are:
 *
 *   C0 and DEL          00..1F, 7F, newline and tab included
 *   C1                  U+0080..U+009F, and bytes 80..9F alone, which 8-bit terminals obey
 *   no UTF-8            any byte that belongs to no well-formed sequence
 *   separators          U+2028, U+2029
 *   direction           U+061C, U+200E, U+200F, U+202A..U+202E, U+2066..U+2069
 */
#ifndef OST_CORE_PRINTABLE_H
#define OST_CORE_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Decodes the code point at text, which ends with a NUL, and sets *bytes to its length; -1, and one byte, where no UTF-8 begins. */
int32_t ost_code_point(const char *text, size_t *bytes);

/* Returns true if a terminal shows the code point and does nothing else with it. */
int ost_code_point_is_printable(int32_t code);

/* Replaces every character of the lists above by '?', in place; the text never becomes longer. */
void ost_make_printable(char *text);

#endif
