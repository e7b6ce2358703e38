/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists possible causes of the differences of a class. The causes are the deliberate mistakes that caused such
 * differences when the sensitivity of the campaign was measured (sensitivity.h). Their numbers do not show how frequent
 * a kind of mistake is in real backends.
 */
#ifndef OST_VALIDATION_CAUSES_H
#define OST_VALIDATION_CAUSES_H

enum { CAUSES_NAMED = 3, CAUSES_TEXT = 320 };

/* The mistakes that caused differences of one class: their number, the number of their kinds, and the most frequent
   kinds. */
typedef struct causes {
    const char *class;
    int mistakes, kinds;
    struct {
        const char *kind; /* name of a kind of mistake (dense/deviation.h); NULL in unused rows */
        int mistakes;
    } most[CAUSES_NAMED];
} causes;

/* Returns the possible causes of a class of differences; NULL if the table does not contain the class. */
const causes *causes_of(const char *class);

/* Writes a sentence that lists the most frequent kinds of mistakes as possible causes, with their shares in percent.
   Writes "" if no cause is known. */
void causes_text(const char *class, char out[CAUSES_TEXT]);

#endif
