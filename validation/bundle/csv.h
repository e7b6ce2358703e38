/* SPDX-License-Identifier: Apache-2.0 */
/* Writes fields of the bundle's tables (RFC 4180). Every field is quoted and has one line. */
#ifndef OST_VALIDATION_CSV_H
#define OST_VALIDATION_CSV_H

#include <stdio.h>

/* Writes a field, with control characters replaced by spaces, and then the character `after`. This character is a
   newline after the last field of a row, and a comma after any other field. */
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
