/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes HTML. Text is escaped, files of the bundle become links, and pictures are embedded in the page.
 * Text from a bundle may be written only by the functions below.
 */
#ifndef OST_VALIDATION_REPORT_PAGE_H
#define OST_VALIDATION_REPORT_PAGE_H

#include <stdbool.h>
#include <stdio.h>

#include <jansson.h>

#include <osteon/status.h>

#include "validation/bundle/evidence.h"

typedef struct page {
    FILE *to;
    const char *folder; /* path of the bundle's folder */
    const json_t *protocol, *cases, *summary;
    /* error of the first bundle file that could not be read; the page is not written after such an error */
    ost_error *unread;
} page;

/* Writes text escaped for HTML. It may be used in the text of elements and in quoted attributes. Control characters
   become '?'. */
void page_text(const page *p, const char *text);
/* Writes a number with thousands separators, such as "12,345". */
void page_count(const page *p, json_int_t value);
/* Writes a number with a noun in the singular or plural, such as "1 case" or "12,345 cases". */
void page_many(const page *p, size_t count, const char *one);
/* Writes text so that a shell reads it as one word. */
void page_shell_word(const page *p, const char *text);
/* Writes a link to a file of the bundle. */
void page_link(const page *p, const char *file);
/* Reads a file of the bundle into *bytes, which the caller frees. Returns false if the file is absent. If the file
   cannot be read, returns false and records the error in p->unread. */
bool page_read(const page *p, const char *file, char **bytes, size_t *size);
/* Returns the value of a JSON file in the bundle; the caller owns the value. Returns NULL if the file is absent or is
   not JSON. If the file cannot be read, returns NULL and records the error in p->unread. */
json_t *page_json(const page *p, const char *file);
bool page_has(const page *p, const char *file);
/* Embeds a picture with a caption in the page and links the picture to its file. If the bundle does not have the
   picture, writes nothing and returns false. */
bool page_picture(const page *p, const char *file, const char *caption);

/*
 * These functions begin and end a labelled part of the page. On a screen the reader opens the part
 * with its label; on paper the part is always open. The HTML element `details` is not used, because some
 * browsers print it closed. The content of the part is one div. The id must be unique on the page.
 */
void page_fold_begin(const page *p, const char *id, bool open, const char *label);
void page_fold_end(const page *p);

/* These functions begin and end the page. The beginning of the page contains the page's style sheet. */
void page_begin(const page *p, const char *title);
void page_end(const page *p);

#endif
