/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes text from files, file names and devices safe for output on a terminal.
 *
 * Such text may contain characters that move the cursor, change colours, make the
 * terminal answer a query or change the direction of the text.  The terminal could then show a
 * different message.  The following characters can have such effects:
 *
 *   C0 and DEL          00..1F, 7F, including newline and tab
 *   C1                  U+0080..U+009F, and single bytes 80..9F, which 8-bit terminals execute
 *   not UTF-8           any byte that belongs to no well-formed sequence
 *   separators          U+2028, U+2029
 *   direction           U+061C, U+200E, U+200F, U+202A..U+202E, U+2066..U+2069
 */
#ifndef OST_CORE_PRINTABLE_H
#define OST_CORE_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/*
 * Decodes the code point at the start of the NUL-terminated string `text`, and sets *bytes to the length of the code
 * point. Returns -1 and sets *bytes to 1 if the text does not start with well-formed UTF-8.
 */
int32_t ost_code_point(const char *text, size_t *bytes);

/*
 * Returns true if the code point is not in the list at the top of this file. A terminal displays such a code point and
 * does not interpret it.
 */
int ost_code_point_is_printable(int32_t code);

/*
 * Replaces every character in the list at the top of this file with '?', in place. The text does not become longer.
 */
void ost_make_printable(char *text);

#endif
