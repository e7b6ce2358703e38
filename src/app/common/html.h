/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes an HTML page piece by piece. The file appears only when it is complete (io/outfile.h). The first failure is
 * stored in the field status; all later calls write nothing.
 */
#ifndef OST_APP_COMMON_HTML_H
#define OST_APP_COMMON_HTML_H

#include "io/outfile.h"

typedef struct html_page {
    ost_outfile *file;
    ost_status status;
    ost_error *err;
} html_page;

void html_text(html_page *p, const char *bytes);
/* Writes text in which < > & and " are replaced by entities. */
void html_escaped(html_page *p, const char *text);
void html_base64(html_page *p, const uint8_t *bytes, size_t size);

#define html_print(p, ...)                                                      \
    do {                                                                        \
        if ((p)->status == OST_OK)                                              \
            (p)->status = ost_outfile_printf((p)->file, (p)->err, __VA_ARGS__); \
    } while (0)

#endif
