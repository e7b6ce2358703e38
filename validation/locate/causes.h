/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The causes of a class of differences where they are known: the mistakes of the
 * sensitivity proof, which are made on purpose.  A share among
 * those is no probability for a backend, whose mistakes nobody has counted.
 */
#ifndef OST_VALIDATION_CAUSES_H
#define OST_VALIDATION_CAUSES_H

enum { CAUSES_NAMED = 3, CAUSES_TEXT = 320 };

/* The known mistakes of one class: how many, of how many kinds, and the most frequent kinds. */
typedef struct causes {
    const char *class;
    int mistakes, kinds;
    struct {
        const char *kind; /* of dense/deviation.h; NULL: there are fewer */
        int mistakes;
    } most[CAUSES_NAMED];
} causes;

/* NULL where the class is none of the table's. */
const causes *causes_of(const char *class);

/* Writes a sentence with the kinds and their shares, worded as a possibility; "" where nothing is known. */
void causes_text(const char *class, char out[CAUSES_TEXT]);

#endif
