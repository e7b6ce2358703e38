/* SPDX-License-Identifier: Apache-2.0 */
/* A field of the bundle's tables (RFC 4180): always in quotes, on one line. */
#ifndef OST_VALIDATION_CSV_H
#define OST_VALIDATION_CSV_H

#include <stdio.h>

/* Control characters become spaces; after is ',' or, behind the last field, a line's end. */
static inline void put_csv(FILE *to, const char *text, char after)
{
    fputc('"', to);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', to);
        fputc((unsigned char)*text < ' ' ? ' ' : *text, to);
    }
    fputc('"', to);
    fputc(after, to);
}

#endif
