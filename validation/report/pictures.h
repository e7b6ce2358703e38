/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the campaign's pictures: the reference's result of the built-in operation, and the differences of
 * backends.
 *
 *   reference's trace            --pictures_of_operation--> before, after, slices-before, slices-after .png
 *   both traces at a difference  --pictures_of_difference--> reference | got | difference
 *
 * A tick's record has only the leaves that changed, so the bone before a tick is made by applying the
 * reference's records of all earlier ticks in order. This bone is the same in both traces, because they are
 * equal up to the first difference. The tick's record of each trace is then applied to a copy of this bone.
 */
#ifndef OST_VALIDATION_REPORT_PICTURES_H
#define OST_VALIDATION_REPORT_PICTURES_H

#include "validation/bundle/evidence.h"

#define PICTURE_BEFORE "pictures/before.png"
#define PICTURE_AFTER "pictures/after.png"
#define PICTURE_SLICES_BEFORE "pictures/slices-before.png"
#define PICTURE_SLICES_AFTER "pictures/slices-after.png"

enum {
    /* maximum number of cases per backend that get pictures; these are the first cases that differ */
    PICTURES_A_BACKEND = 4,
    /* maximum number of backends that get pictures; these are the first backends of the list */
    PICTURES_BACKENDS = 256,
    PICTURE_NAME = 128
};

typedef enum picture_role { PICTURE_REFERENCE, PICTURE_GOT, PICTURE_DIFFERENCE, PICTURE_ROLES } picture_role;

/* Writes a picture's name, such as "pictures/mesh-3-backend-2-got.png". `backend` is the index in the protocol's list
   of backends. */
void picture_name(char name[PICTURE_NAME], const char *case_id, size_t backend, picture_role role);

/* Makes the pictures of the operation. Does nothing if libpng is missing or the open batch has no case of the
   operation. */
ost_status pictures_of_operation(const campaign *c, evidence_sink *sink, void *user, ost_error *err);

/* The state of the callback pictures_of_difference (campaign_options.differs). */
typedef struct picture_keeper {
    evidence_sink *sink;
    void *user;
    int drawn[PICTURES_BACKENDS]; /* for each backend, the number of cases with pictures so far */
    ost_error err; /* the first error */
} picture_keeper;
void pictures_of_difference(void *keeper, const campaign *c, int case_index, int subject_index, const trace *got,
                            compare_range in_got);

/* Copies pictures and small cases (reproduce.h) from the bundles of shards in a folder. Copies only those pictures that
   a single run would have made. `protocol` and `cases` are those of the complete campaign. */
ost_status pictures_of_shards(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                              void *user, ost_error *err);

#endif
