/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The campaign's pictures: the reference's result of the built-in operation, and
 * the differences of backends.
 *
 *   reference's trace            --pictures_of_operation--> before.png, after.png, slices.png
 *   both traces at a difference  --pictures_of_difference--> reference | got | difference
 *
 * A tick's record has only the leaves that changed, so the bone at a tick is
 * made by applying the reference's records up to this tick in order: until the
 * first difference both bones are the reference's.
 */
#ifndef OST_VALIDATION_REPORT_PICTURES_H
#define OST_VALIDATION_REPORT_PICTURES_H

#include "validation/bundle/evidence.h"

#define PICTURE_BEFORE "pictures/before.png"
#define PICTURE_AFTER "pictures/after.png"
#define PICTURE_SLICES_BEFORE "pictures/slices-before.png"
#define PICTURE_SLICES_AFTER "pictures/slices-after.png"

enum {
    /* maximum number of cases of one backend that get pictures: the first ones that differ */
    PICTURES_A_BACKEND = 4,
    PICTURES_BACKENDS = 256, /* maximum number of backends that get pictures: the first ones in the list */
    PICTURE_NAME = 128
};

typedef enum picture_role { PICTURE_REFERENCE, PICTURE_GOT, PICTURE_DIFFERENCE, PICTURE_ROLES } picture_role;

/* Writes a picture's name, "pictures/mesh-3-backend-2-got.png"; backend is the index in the protocol. */
void picture_name(char name[PICTURE_NAME], const char *case_id, size_t backend, picture_role role);

/* Makes the pictures of the operation. Does nothing without libpng, or if the open batch has no case of the
   operation. */
ost_status pictures_of_operation(const campaign *c, evidence_sink *sink, void *user, ost_error *err);

/* The data of pictures_of_difference, which is passed to campaign_options.differs. */
typedef struct picture_keeper {
    evidence_sink *sink;
    void *user;
    int drawn[PICTURES_BACKENDS]; /* number of pictures of each backend */
    ost_error err; /* the first error */
} picture_keeper;
void pictures_of_difference(void *keeper, const campaign *c, int case_index, int subject_index, const trace *got,
                            compare_range in_got);

/* Copies pictures from the bundles of shards in a folder: those pictures that a single run would have made. The
   parameters protocol and cases are those of the complete campaign. */
ost_status pictures_of_shards(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                              void *user, ost_error *err);

#endif
