/* SPDX-License-Identifier: Apache-2.0 */
#include "core/printable.h"

#include <string.h>

int32_t ost_code_point(const char *text, size_t *bytes)
{
    const unsigned char *p = (const unsigned char *)text;
    static const int32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t length = p[0] < 0x80 ? 1 : p[0] >> 5 == 6 ? 2 : p[0] >> 4 == 14 ? 3 : p[0] >> 3 == 30 ? 4 : 0;
    *bytes = 1;
    if (length == 0)
        return -1;
    int32_t code = length == 1 ? p[0] : p[0] & (0xff >> (length + 1));
    for (size_t i = 1; i < length; i++) {
        if ((p[i] & 0xc0) != 0x80)
            return -1;
        code = code << 6 | (p[i] & 0x3f);
    }
    /* Rejects overlong sequences, surrogates and code points above U+10FFFF, as UTF-8 requires. */
    if (code < least[length] || (code >= 0xd800 && code <= 0xdfff) || code > 0x10ffff)
        return -1;
    *bytes = length;
    return code;
}

int ost_code_point_is_printable(int32_t code)
{
    return code >= 0x20 && !(code >= 0x7f && code <= 0x9f) && code != 0x61c && code != 0x200e && code != 0x200f &&
           !(code >= 0x2028 && code <= 0x202e) && !(code >= 0x2066 && code <= 0x2069);
}

void ost_make_printable(char *text)
{
    char *to = text;
    while (*text) {
        size_t bytes;
        if (ost_code_point_is_printable(ost_code_point(text, &bytes))) {
            memmove(to, text, bytes);
            to += bytes;
        } else {
            *to++ = '?';
        }
        text += bytes;
    }
    *to = '\0';
}
