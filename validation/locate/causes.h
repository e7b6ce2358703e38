/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The known causes of a class of differences.  They are the deliberate mistakes by
 * which sensitivity.h measures the campaign.  The share of a kind among these
 * mistakes is not a probability for a backend, because the mistakes of backends
 * have not been counted.
 */
#ifndef OST_VALIDATION_CAUSES_H
#define OST_VALIDATION_CAUSES_H

enum { CAUSES_NAMED = 3, CAUSES_TEXT = 320 };

/* The known mistakes of one class: their number, the number of their kinds, and the most frequent kinds. */
typedef struct causes {
    const char *class;
    int mistakes, kinds;
    struct {
        const char *kind; /* name in dense/deviation.h; NULL if there are fewer kinds */
        int mistakes;
    } most[CAUSES_NAMED];
} causes;

/* Returns the causes of a class; NULL if the class is not in the table. */
const causes *causes_of(const char *class);

/* Writes a sentence that lists the kinds and their shares as possible causes; "" if no cause is known. */
void causes_text(const char *class, char out[CAUSES_TEXT]);

#endif
