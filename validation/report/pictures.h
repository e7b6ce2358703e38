/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The campaign's pictures: what the reference made of the built-in operation,
 * and what differs where a backend made something else.
 *
 *   reference's trace            --pictures_of_operation--> before.png, after.png, slices.png
 *   both traces at a difference  --pictures_of_difference--> reference | got | difference
 *
 * A tick's record has only the leaves that changed, so the bone at a tick is
 * made by laying the reference's records over each other up to it: until the
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
    PICTURES_A_BACKEND = 4, /* differing cases of one backend that get pictures: its first ones */
    PICTURES_BACKENDS = 256, /* those after so many get none */
    PICTURE_NAME = 128
};

typedef enum picture_role { PICTURE_REFERENCE, PICTURE_GOT, PICTURE_DIFFERENCE, PICTURE_ROLES } picture_role;

/* "pictures/mesh-3-backend-2-got.png"; the backend by its place in the protocol. */
void picture_name(char name[PICTURE_NAME], const char *case_id, size_t backend, picture_role role);

/* No pictures, and no error, without libpng or without a case of the operation in the batch that is there. */
ost_status pictures_of_operation(const campaign *c, evidence_sink *sink, void *user, ost_error *err);

/* What campaign_options.differs is given. */
typedef struct picture_keeper {
    evidence_sink *sink;
    void *user;
    int kept[PICTURES_BACKENDS]; /* of each backend */
    ost_error err; /* the first thing that went wrong */
} picture_keeper;
void pictures_of_difference(void *keeper, const campaign *c, int case_index, int whom, const trace *got, compare_range in_got);

/* Those that a single run of the whole would have kept, from the shards' bundles in a folder; protocol and cases are the whole's. */
ost_status pictures_of_shards(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink, void *user, ost_error *err);

#endif
