/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes HTML: text is escaped, files of the bundle become links, and pictures
 * become a part of the page.  Text from a bundle is written only by these
 * functions.
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
    const char *folder; /* the folder of the bundle */
    const json_t *protocol, *cases, *summary;
    ost_error *unread; /* error of the first file of the bundle that could not be read; the page is then not written */
} page;

/* Writes text escaped for HTML, both for the text of elements and for quoted attributes; control characters become
   '?'. */
void page_text(const page *p, const char *text);
/* Writes a number as 12,345. */
void page_count(const page *p, json_int_t value);
/* Writes a number with its noun: 1 case, 12,345 cases. */
void page_many(const page *p, size_t count, const char *one);
/* Writes text quoted as one word for a shell. */
void page_shell_word(const page *p, const char *text);
/* Writes a link to a file of the bundle. */
void page_link(const page *p, const char *file);
/* Reads a file of the bundle into *bytes, which the caller frees. Returns false if the file is absent or cannot be
   read (p->unread). */
bool page_read(const page *p, const char *file, char **bytes, size_t *size);
/* Returns a JSON file of the bundle, owned by the caller; NULL if it is absent, cannot be read (p->unread) or is not
   JSON. */
json_t *page_json(const page *p, const char *file);
bool page_has(const page *p, const char *file);
/* Embeds a picture with a caption in the page and links the picture to its file. Writes nothing and returns false if
   the bundle does not have the picture. */
bool page_picture(const page *p, const char *file, const char *caption);

/*
 * Begin and end a part of the page that has a label. On a screen the part is opened by its label;
 * on paper the part is always open. The element details is not used, because some browsers print it
 * closed. The content of the part is one div. The id must be unique on the page.
 */
void page_fold_begin(const page *p, const char *id, bool open, const char *label);
void page_fold_end(const page *p);

/* Begin and end the page. The beginning of the page contains its style. */
void page_begin(const page *p, const char *title);
void page_end(const page *p);

#endif
