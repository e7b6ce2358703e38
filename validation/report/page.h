/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HTML as it is written: text is escaped, files of the bundle are links, and
 * pictures become a part of the page.  Nothing from a bundle is written but by
 * these.
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
    const char *folder; /* the bundle as it lies */
    const json_t *protocol, *cases, *summary;
    ost_error *unread; /* the first file of the bundle that could not be read; a page is then not written */
} page;

/* Escaped for HTML, within text and within quoted attributes; control characters become '?'. */
void page_text(const page *p, const char *text);
/* 12,345 */
void page_count(const page *p, json_int_t value);
/* 1 case, 12,345 cases */
void page_many(const page *p, size_t count, const char *one);
/* As one word for a shell. */
void page_shell_word(const page *p, const char *text);
/* A link to a file of the bundle. */
void page_link(const page *p, const char *file);
/* Reads a file of the bundle, which the caller frees; returns false when it is absent or cannot be read (p->unread). */
bool page_read(const page *p, const char *file, char **bytes, size_t *size);
/* Returns a JSON file of the bundle, a reference of the caller; NULL when it is absent, cannot be read (p->unread) or is no JSON. */
json_t *page_json(const page *p, const char *file);
bool page_has(const page *p, const char *file);
/* The picture in the page, linked to its file, with a caption of ours; nothing when the bundle has none. */
bool page_picture(const page *p, const char *file, const char *caption);

/*
 * A part that opens by its label on a screen and is always open on paper, which the element details is not in every
 * browser.  Its content is one div.  id is unique on the page.
 */
void page_fold_begin(const page *p, const char *id, bool open, const char *label);
void page_fold_end(const page *p);

/* Opens and closes: style is a part of the first. */
void page_begin(const page *p, const char *title);
void page_end(const page *p);

#endif
