/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/html.h"

#include <string.h>

void html_text(html_page *p, const char *bytes)
{
    if (p->status == OST_OK)
        p->status = ost_outfile_write(p->file, bytes, strlen(bytes), p->err);
}

void html_escaped(html_page *p, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '<': html_text(p, "&lt;"); break;
        case '>': html_text(p, "&gt;"); break;
        case '&': html_text(p, "&amp;"); break;
        case '"': html_text(p, "&quot;"); break;
        default: {
            const char one[2] = {*text, '\0'};
            html_text(p, one);
        }
        }
}

void html_base64(html_page *p, const uint8_t *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char block[4097];
    size_t used = 0;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t three = (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) |
                         (left > 2 ? bytes[i + 2] : 0u);
        block[used++] = digit[three >> 18];
        block[used++] = digit[three >> 12 & 63];
        block[used++] = left > 1 ? digit[three >> 6 & 63] : '=';
        block[used++] = left > 2 ? digit[three & 63] : '=';
        if (used == 4096 || i + 3 >= size) {
            block[used] = '\0';
            html_text(p, block);
            used = 0;
        }
    }
}
